//! [`Value`]: a JSON document as a tree of small values that borrow their text.
//!
//! The tree takes at most some forty bytes for each byte of text, its growth included, and is as
//! deep as the door allows. Reading from it is lenient, for files are not: what is absent and what
//! has the wrong type is both "not there", except for indices, where a wrong one is told apart.

use crate::load::Door;
use chiaro_basis::Result;
use serde::de::{DeserializeSeed, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use std::borrow::Cow;
use std::fmt;

/// A JSON value.
#[derive(Debug)]
pub(super) enum Value<'t> {
    Null,
    Flag(bool),
    Number(f64),
    Text(Cow<'t, str>),
    List(Box<[Value<'t>]>),
    Object(Box<[(Cow<'t, str>, Value<'t>)]>),
}

static NULL: Value<'static> = Value::Null;

/// The document in `text`; [`chiaro_basis::Error::Input`] names line and column.
pub(super) fn parse<'t>(text: &'t str, door: &Door) -> Result<Value<'t>> {
    let mut reader = serde_json::Deserializer::from_str(text);
    let depth = door.left.depth;
    let value = Depth(depth).deserialize(&mut reader).and_then(|v| reader.end().map(|()| v));
    value.map_err(|e| {
        let place = format!("line {}, column {}", e.line(), e.column());
        let what = e.to_string();
        let what = what.split(" at line ").next().unwrap_or_default().to_owned();
        door.error(place, format!("this is no JSON ({what}); export the scene again"))
    })
}

impl<'t> Value<'t> {
    /// The member `key`; null where there is none. Of several the last counts.
    pub(super) fn get(&self, key: &str) -> &Value<'t> {
        let Value::Object(members) = self else { return &NULL };
        let at = members.binary_search_by(|(k, _)| k.as_ref().cmp(key));
        at.map_or(&NULL, |i| &members[i].1)
    }

    /// The extension `name`; null where there is none.
    pub(super) fn extension(&self, name: &str) -> &Value<'t> {
        self.get("extensions").get(name)
    }

    pub(super) fn is_object(&self) -> bool {
        matches!(self, Value::Object(_))
    }

    /// The entries of the list `key`; none where there is no list.
    pub(super) fn list(&self, key: &str) -> &[Value<'t>] {
        if let Value::List(items) = self.get(key) { items } else { &[] }
    }

    pub(super) fn as_text(&self) -> Option<&str> {
        if let Value::Text(text) = self { Some(text) } else { None }
    }

    pub(super) fn text(&self, key: &str) -> Option<&str> {
        self.get(key).as_text()
    }

    /// The text `name`, empty where there is none, without control characters.
    pub(super) fn name(&self) -> String {
        let name = self.text("name").unwrap_or_default();
        name.chars().filter(|c| !c.is_control()).collect()
    }

    pub(super) fn flag(&self, key: &str) -> bool {
        matches!(self.get(key), Value::Flag(true))
    }

    pub(super) fn as_number(&self) -> Option<f64> {
        if let Value::Number(n) = self { Some(*n) } else { None }
    }

    pub(super) fn number(&self, key: &str) -> Option<f64> {
        self.get(key).as_number()
    }

    /// The list `key` of exactly `N` numbers.
    pub(super) fn numbers<const N: usize>(&self, key: &str) -> Option<[f64; N]> {
        let items = self.list(key);
        let mut numbers = [0.0; N];
        for (slot, item) in numbers.iter_mut().zip(items) {
            *slot = item.as_number()?;
        }
        (items.len() == N).then_some(numbers)
    }

    /// A whole number from 0, as counts, offsets and indices are.
    pub(super) fn as_whole(&self) -> Option<usize> {
        let n = self.as_number()?;
        (n >= 0.0 && n.fract() == 0.0 && n < 9e15).then_some(n as usize)
    }

    /// The whole number `key`; `absent` where there is none. `Err` says what is there instead.
    pub(super) fn whole(&self, key: &str, absent: usize) -> std::result::Result<usize, String> {
        match self.get(key) {
            Value::Null => Ok(absent),
            value => value.as_whole().ok_or_else(|| format!("its {key} is no whole number from 0")),
        }
    }

    /// The index `key` into a list of `count` things; `Err` says why there is no such thing.
    pub(super) fn index(
        &self,
        key: &str,
        count: usize,
    ) -> std::result::Result<Option<usize>, String> {
        match self.get(key) {
            Value::Null => Ok(None),
            value => value.as_index(key, count).map(Some),
        }
    }

    /// This value as an index into a list of `count` things called `what`.
    pub(super) fn as_index(&self, what: &str, count: usize) -> std::result::Result<usize, String> {
        let i = self.as_whole().ok_or_else(|| format!("its {what} is no index"))?;
        let why = || format!("its {what} {i} does not exist, the file has {count}");
        (i < count).then_some(i).ok_or_else(why)
    }
}

/// A reader of one value that may nest this deep.
struct Depth(u64);

impl<'t> DeserializeSeed<'t> for Depth {
    type Value = Value<'t>;
    fn deserialize<D: Deserializer<'t>>(
        self,
        reader: D,
    ) -> std::result::Result<Value<'t>, D::Error> {
        reader.deserialize_any(self)
    }
}

impl Depth {
    fn deeper<E: serde::de::Error>(&self) -> std::result::Result<u64, E> {
        self.0.checked_sub(1).ok_or_else(|| E::custom("it is nested too deep"))
    }
}

impl<'t> Visitor<'t> for Depth {
    type Value = Value<'t>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> std::result::Result<Value<'t>, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, v: bool) -> std::result::Result<Value<'t>, E> {
        Ok(Value::Flag(v))
    }

    fn visit_i64<E>(self, v: i64) -> std::result::Result<Value<'t>, E> {
        Ok(Value::Number(v as f64))
    }

    fn visit_u64<E>(self, v: u64) -> std::result::Result<Value<'t>, E> {
        Ok(Value::Number(v as f64))
    }

    fn visit_f64<E>(self, v: f64) -> std::result::Result<Value<'t>, E> {
        Ok(Value::Number(v))
    }

    fn visit_borrowed_str<E>(self, v: &'t str) -> std::result::Result<Value<'t>, E> {
        Ok(Value::Text(Cow::Borrowed(v)))
    }

    fn visit_str<E>(self, v: &str) -> std::result::Result<Value<'t>, E> {
        Ok(Value::Text(Cow::Owned(v.to_owned())))
    }

    fn visit_seq<A: SeqAccess<'t>>(self, mut list: A) -> std::result::Result<Value<'t>, A::Error> {
        let depth = self.deeper::<A::Error>()?;
        let mut items = Vec::new();
        while let Some(item) = list.next_element_seed(Depth(depth))? {
            items.push(item);
        }
        Ok(Value::List(items.into()))
    }

    fn visit_map<A: MapAccess<'t>>(self, mut map: A) -> std::result::Result<Value<'t>, A::Error> {
        let depth = self.deeper::<A::Error>()?;
        let mut members = Vec::new();
        while let Some(key) = map.next_key_seed(Depth(0))? {
            let Value::Text(key) = key else { return Err(A::Error::custom("a key is no text")) };
            members.push((key, map.next_value_seed(Depth(depth))?));
        }
        // Sorted, with the last of each name in front, so that finding one is fast in any file.
        members.reverse();
        members.sort_by(|(a, _), (b, _)| a.cmp(b));
        members.dedup_by(|(a, _), (b, _)| a == b);
        Ok(Value::Object(members.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn door() -> Door<'static> {
        Door::new("a.gltf", &(), crate::load::Budget::default())
    }

    #[test]
    fn members_of_the_wrong_type_are_absent() {
        let v =
            parse(r#"{"a": 1.5, "b": [1, 2], "c": null, "n": "x\ny", "a": 2}"#, &door()).unwrap();
        assert_eq!(v.number("a"), Some(2.0));
        assert_eq!(v.text("a"), None);
        assert_eq!(v.numbers::<2>("b"), Some([1.0, 2.0]));
        assert_eq!(v.numbers::<3>("b"), None);
        assert_eq!(v.text("n"), Some("x\ny"));
        assert!(v.get("none").get("deeper").list("at all").is_empty());
    }

    #[test]
    fn wrong_indices_say_what_they_are() {
        let v = parse(r#"{"a": 3, "b": -1, "c": 1e300, "d": "0", "e": null}"#, &door()).unwrap();
        assert_eq!(v.index("a", 4), Ok(Some(3)));
        assert_eq!(v.index("a", 3), Err("its a 3 does not exist, the file has 3".into()));
        for key in ["b", "c", "d"] {
            assert_eq!(v.index(key, 4), Err(format!("its {key} is no index")));
        }
        assert_eq!(v.index("e", 4), Ok(None));
    }

    #[test]
    fn what_is_no_json_names_the_line_and_deep_nests_end() {
        let why = parse("{\n\"a\": uh}", &door()).unwrap_err().to_string();
        assert!(why.starts_with("a.gltf: line 2, column 6: "), "{why}");
        for text in ["[".repeat(200_000), "{\"a\":".repeat(200_000)] {
            assert!(parse(&text, &door()).is_err());
        }
        let mut shallow = door();
        shallow.left.depth = 2;
        assert!(parse("[[1]]", &shallow).is_ok());
        assert!(parse("[[[1]]]", &shallow).is_err());
        assert!(parse("{} {}", &door()).is_err());
    }
}
