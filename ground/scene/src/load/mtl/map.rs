//! A map statement: a picture's name among options.

/// A picture and how it is laid on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    pub(super) name: String,
    /// `-s`: texture coordinates times this, v up.
    pub(super) scale: [f32; 2],
    /// `-o`: and plus this.
    pub(super) offset: [f32; 2],
    /// `-bm`: how much of a bump.
    pub(super) strength: f32,
    /// `-clamp on`.
    pub(super) clamped: bool,
    /// Whether it holds normals, whatever it looks like.
    pub(super) holds_normals: bool,
}

impl Map {
    /// Reads a statement, its key left out; none when it names no picture. Options may come before
    /// and after the name, which may hold spaces.
    pub(super) fn read(rest: &str) -> Option<Self> {
        let mut map = Self {
            name: String::new(),
            scale: [1.0; 2],
            offset: [0.0; 2],
            strength: 1.0,
            clamped: false,
            holds_normals: false,
        };
        let mut rest = map.options(rest.trim());
        let mut end = rest.len();
        // The first option after the name ends it.
        for (i, _) in rest.match_indices(" -") {
            if most_values(rest[i + 1..].split_whitespace().next().unwrap_or_default()).is_some() {
                map.options(&rest[i + 1..]);
                end = i;
                break;
            }
        }
        rest = rest[..end].trim();
        map.name = rest.trim_matches('"').into();
        (!map.name.is_empty()).then_some(map)
    }

    /// Takes the options at the start, and hands back what follows them.
    fn options<'a>(&mut self, mut rest: &'a str) -> &'a str {
        loop {
            let (option, after) = first_word(rest);
            let Some(most) = most_values(option) else { return rest };
            let mut values: Vec<&str> = Vec::new();
            rest = after;
            while values.len() < most {
                let (value, after) = first_word(rest);
                let fits = !value.is_empty() && (most == 1 || value.parse::<f32>().is_ok());
                if !fits {
                    break;
                }
                values.push(value);
                rest = after;
            }
            self.set(option, &values);
        }
    }

    fn set(&mut self, option: &str, values: &[&str]) {
        let number =
            |i: usize| values.get(i).and_then(|v| v.parse::<f32>().ok()).filter(|x| x.is_finite());
        match option {
            "-s" => self.scale = [number(0).unwrap_or(1.0), number(1).unwrap_or(1.0)],
            "-o" => self.offset = [number(0).unwrap_or(0.0), number(1).unwrap_or(0.0)],
            "-bm" => self.strength = number(0).unwrap_or(1.0).clamp(-16.0, 16.0),
            "-clamp" => self.clamped = values.first() == Some(&"on"),
            _ => {}
        }
    }

    /// Rows of the matrix from texture coordinates to the picture's, both with v down.
    pub(super) fn matrix(&self) -> [[f32; 3]; 2] {
        let ([su, sv], [ou, ov]) = (self.scale, self.offset);
        [[su, 0.0, ou], [0.0, sv, 1.0 - sv - ov]]
    }
}

/// How many values an option takes at most; none for what is no option.
fn most_values(word: &str) -> Option<usize> {
    match word {
        "-o" | "-s" | "-t" => Some(3),
        "-mm" => Some(2),
        "-blendu" | "-blendv" | "-boost" | "-cc" | "-clamp" | "-imfchan" | "-texres" | "-type"
        | "-bm" | "-colorspace" => Some(1),
        _ => None,
    }
}

/// The first word, and what follows it.
fn first_word(text: &str) -> (&str, &str) {
    let text = text.trim_start();
    text.split_at(text.find(char::is_whitespace).unwrap_or(text.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_stands_among_options() {
        for (line, name) in [
            ("a.png", "a.png"),
            ("-o 0 0 -s 2 2 2 -bm 0.3 wood floor.png", "wood floor.png"),
            ("-clamp on a.png", "a.png"),
            ("-t 0.1 0.2 0.3 a - b.png", "a - b.png"),
            ("-imfchan r bump  2.jpg -bm 1.5", "bump  2.jpg"),
            ("-type sphere \"C:\\maps\\a b.jpg\"", "C:\\maps\\a b.jpg"),
            ("-mm 0.1 0.3 1.png", "1.png"),
        ] {
            assert_eq!(Map::read(line).unwrap().name, name, "{line}");
        }
        assert_eq!(Map::read("-bm 1"), None);
        assert_eq!(Map::read(""), None);
    }

    #[test]
    fn options_place_the_picture() {
        let map = Map::read("-s 2 4 -o 0.5 0.25 x.png -bm 3 -clamp on").unwrap();
        assert_eq!((map.strength, map.clamped), (3.0, true));
        // The corner u = v = 0 at the lower left goes to (0.5, 0.25) above the lower left.
        let [u, v] = map.matrix();
        let at = |x: f32, y: f32| [u[0] * x + u[1] * y + u[2], v[0] * x + v[1] * y + v[2]];
        assert_eq!(at(0.0, 1.0), [0.5, 1.0 - 0.25]);
        assert_eq!(at(1.0, 0.0), [2.5, 1.0 - 4.25]);
    }
}
