//! Indices that cannot be mixed up.

/// Declares a `u32` index of its own type, for one kind of thing.
///
/// ```
/// chiaro_basis::typed_id! {
///     /// A mesh of a scene.
///     pub struct MeshId;
/// }
/// let third = MeshId::new(2);
/// assert_eq!(third.index(), 2);
/// ```
#[macro_export]
macro_rules! typed_id {
    ($(#[$doc:meta])* $vis:vis struct $name:ident;) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        $vis struct $name(u32);

        impl $name {
            /// The id with this index. Panics past `u32::MAX`, which budgets exclude.
            pub fn new(index: usize) -> Self {
                Self(u32::try_from(index).expect("budgets keep every count below 2^32"))
            }

            /// The index, from 0.
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}
