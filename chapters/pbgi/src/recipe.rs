//! [`Recipe`]: how a node's lobes become a code.

/// How lobes are coded.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Whether sums are divided by the node's area.
    pub by_area: bool,
    /// Whether lobes are turned to the node's mean normal.
    pub turned: bool,
    /// Gains of the light.
    pub gains: Gains,
    /// Words of each stage's table of light; at most 65 536.
    pub light: Vec<usize>,
    /// Words of each stage's table of area.
    pub area: Vec<usize>,
    /// Where words come from.
    pub words: Words,
}

/// Where words come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Words {
    /// Clusters of the training nodes.
    Clustered,
    /// The thesis's clusters: rounds of Lloyd from nodes drawn at random.
    FromRandom,
    /// Training nodes drawn at random: the thesis's baseline.
    Drawn,
}

/// Which gains a code has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gains {
    /// None.
    None,
    /// One for all colours.
    One,
    /// One for each colour.
    Colours,
    /// One for each colour, of a shape that all colours share: 9 numbers.
    Shape,
}

impl Default for Recipe {
    /// One gain, 4 + 3 stages, 9 bytes. In `chiaro figures 6.rate` no code of its size has more
    /// decibels on the whole, and a gain of each colour has less than one decibel more for four bytes.
    fn default() -> Self {
        Self::residual(Gains::One, false, 4, 3)
    }
}

impl Recipe {
    /// The thesis's: k words on raw sums, no gains; no code of the area, which the thesis does not
    /// count: [`Classic`](crate::classic::Classic) keeps it in floats.
    pub fn thesis(words: usize) -> Self {
        Self {
            by_area: false,
            turned: false,
            gains: Gains::None,
            light: vec![words],
            area: Vec::new(),
            words: Words::FromRandom,
        }
    }

    /// k words on raw sums, and as many on those of area.
    pub fn raw(words: usize) -> Self {
        Self { area: vec![words], ..Self::thesis(words) }
    }

    /// k words on vectors over area, and as many on those of area.
    pub fn clusters(words: usize) -> Self {
        Self { by_area: true, words: Words::Clustered, ..Self::raw(words) }
    }

    /// Residual quantization: `light` and `area` tables of 256 words, after gains.
    pub fn residual(gains: Gains, turned: bool, light: usize, area: usize) -> Self {
        Self {
            by_area: true,
            turned,
            gains,
            light: vec![256; light],
            area: vec![256; area],
            words: Words::Clustered,
        }
    }

    /// Colour times shape: gains of each colour, a shape of the light and one of the area out of so
    /// many.
    pub fn shapes(light: usize, area: usize) -> Self {
        let (light, area) = (vec![light], vec![area]);
        Self { light, area, ..Self::residual(Gains::Shape, true, 1, 1) }
    }

    /// Bytes of a code.
    pub fn bytes(&self) -> usize {
        2 * self.gains.count()
            + self.light.iter().chain(&self.area).map(|words| word_bytes(*words)).sum::<usize>()
    }

    /// Bits of a code, as the thesis counts them.
    pub fn bits(&self) -> usize {
        self.widths().iter().sum::<u32>() as usize
    }

    /// Bits of what a code says of light.
    pub(crate) fn light_bits(&self) -> usize {
        let stages: u32 = self.light.iter().map(|w| word_bits(*w)).sum();
        16 * self.gains.count() + stages as usize
    }

    /// Bits of each number of a code.
    pub(crate) fn widths(&self) -> Vec<u32> {
        let gains = std::iter::repeat_n(16, self.gains.count());
        gains.chain(self.stages().map(word_bits)).collect()
    }

    fn stages(&self) -> impl Iterator<Item = usize> + '_ {
        self.light.iter().chain(&self.area).copied()
    }

    /// Bytes of each number of a code.
    fn sizes(&self) -> impl Iterator<Item = usize> + '_ {
        std::iter::repeat_n(2, self.gains.count()).chain(self.stages().map(word_bytes))
    }

    /// The numbers of a code.
    pub(crate) fn numbers<'a>(&'a self, code: &'a [u8]) -> impl Iterator<Item = u32> + 'a {
        let mut rest = code;
        self.sizes().map(move |size| {
            let (number, after) = rest.split_at(size);
            rest = after;
            number.iter().rev().fold(0, |n, b| n << 8 | u32::from(*b))
        })
    }

    /// The code of numbers.
    pub(crate) fn to_code(&self, numbers: impl Iterator<Item = u32>, code: &mut Vec<u8>) {
        for (number, size) in numbers.zip(self.sizes()) {
            code.extend(&number.to_le_bytes()[..size]);
        }
    }
}

impl Gains {
    /// Gains of a code.
    pub(crate) fn count(self) -> usize {
        match self {
            Self::None => 0,
            Self::One => 1,
            Self::Colours | Self::Shape => 3,
        }
    }

    /// Numbers of a word of light.
    pub(crate) fn dim(self) -> usize {
        if self == Self::Shape { 9 } else { 27 }
    }
}

fn word_bits(words: usize) -> u32 {
    words.next_power_of_two().trailing_zeros()
}

pub(crate) fn word_bytes(words: usize) -> usize {
    if words > 256 { 2 } else { 1 }
}
