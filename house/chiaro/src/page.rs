//! A page that shows pictures: one HTML file with relative links and no scripts.

/// A section of a page.
pub struct Section {
    /// Its heading.
    pub title: String,
    /// What it shows, in a few sentences.
    pub text: String,
    /// Files relative to the page, with their captions.
    pub pictures: Vec<(String, String)>,
}

const STYLE: &str = "
body { font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 76rem; padding: 0 1rem;
  color: #111; background: #fafaf8; }
h1, h2 { font-weight: 600; line-height: 1.2; }
.row { display: flex; flex-wrap: wrap; gap: 1rem; align-items: flex-start; }
figure { margin: 0; flex: 1 1 16rem; max-width: 100%; }
figure.wide { flex-basis: 100%; }
img { max-width: 100%; height: auto; background: #fff; border: 1px solid #ddd; }
figcaption { font-size: 0.9rem; color: #444; }
";

/// The page as HTML.
pub fn html(title: &str, intro: &str, sections: &[Section]) -> String {
    let body: String = sections.iter().map(section).collect();
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>{title}</h1>\n<p>{intro}</p>\n{body}</body>\n</html>\n",
        title = escape(title),
        intro = escape(intro),
    )
}

fn section(s: &Section) -> String {
    let class = if s.pictures.len() == 1 { " class=\"wide\"" } else { "" };
    let figures: String = s
        .pictures
        .iter()
        .map(|(file, caption)| {
            let (file, caption) = (escape(file), escape(caption));
            format!(
                "<figure{class}><img src=\"{file}\" alt=\"{caption}\" loading=\"lazy\">\
                 <figcaption>{caption}</figcaption></figure>\n"
            )
        })
        .collect();
    let (title, text) = (escape(&s.title), escape(&s.text));
    format!("<h2>{title}</h2>\n<p>{text}</p>\n<div class=\"row\">\n{figures}</div>\n")
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        let pictures = vec![("a.png".into(), "g < 1 & \"h\"".into())];
        let page = html("t", "i", &[Section { title: "s".into(), text: String::new(), pictures }]);
        assert!(page.contains("g &lt; 1 &amp; &quot;h&quot;"));
    }
}
