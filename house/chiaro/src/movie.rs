//! Films in one file: animated PNG and GIF of our own, MP4 and WebM by the ffmpeg of this machine.
//!
//! ffmpeg gets the frames over white, row by row, through a pipe, with one thread and without its
//! dates, so that a film has the same bytes whenever the same ffmpeg makes it.

use crate::disk::reason;
use crate::record::Output;
use crate::write;
use chiaro_basis::{Error, Result, Run};
use chiaro_image::codec::{self, Pictures};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// What a film shows.
pub(crate) struct Movie<'a> {
    pub(crate) frames: &'a dyn Pictures,
    /// Frames a second.
    pub(crate) fps: f64,
    pub(crate) recipe: &'a str,
}

/// A file that holds a film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Container {
    Apng,
    Gif,
    Mp4,
    Webm,
}

impl Container {
    /// The container that a file of this ending is.
    pub(crate) fn of(extension: &str) -> Option<Self> {
        match extension {
            "apng" => Some(Self::Apng),
            "gif" => Some(Self::Gif),
            "mp4" => Some(Self::Mp4),
            "webm" => Some(Self::Webm),
            _ => None,
        }
    }

    /// Whether this machine can write it, known before a frame is made.
    pub(crate) fn check(self, path: &Path) -> Result<()> {
        match self {
            Self::Mp4 | Self::Webm => ffmpeg().map(drop).ok_or_else(|| no_ffmpeg(path)),
            Self::Apng | Self::Gif => Ok(()),
        }
    }

    /// Writes a film.
    pub(crate) fn write(self, path: &Path, movie: &Movie, run: &Run) -> Result<Output> {
        let Movie { frames, fps, recipe } = *movie;
        let bytes = match self {
            Self::Apng => codec::write_apng(frames, fps, Some(recipe))?,
            Self::Gif => codec::write_gif(frames, fps, Some(recipe))?,
            Self::Mp4 | Self::Webm => self.encoded(path, movie, run)?,
        };
        write::whole(path, &bytes)
    }

    /// The bytes of a film that ffmpeg encodes into a file of its own.
    fn encoded(self, path: &Path, movie: &Movie, run: &Run) -> Result<Vec<u8>> {
        let program = ffmpeg().ok_or_else(|| no_ffmpeg(path))?;
        let folder = std::env::temp_dir();
        let file = write::beside(&folder.join(path.file_name().unwrap_or_default()));
        let mut command = Command::new(program);
        command.args(self.arguments(movie)).arg(&file);
        let made = encode(command, movie.frames, path, run).and_then(|()| {
            std::fs::read(&file).map_err(|e| Error::output(path.display().to_string(), reason(&e)))
        });
        // What went wrong is told above.
        let _ = std::fs::remove_file(&file);
        made
    }

    fn arguments(self, movie: &Movie) -> Vec<String> {
        let Movie { frames, fps, recipe } = movie;
        let (width, height) = if frames.count() > 0 { frames.size(0) } else { (0, 0) };
        let input = format!(
            "-v error -y -threads 1 -f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {fps} -i - -an"
        );
        // Players want halved chroma, and with it even sides; the paper goes on in white.
        let even = "pad=ceil(iw/2)*2:ceil(ih/2)*2:0:0:white,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p";
        let tags =
            "-colorspace bt709 -color_primaries bt709 -color_trc iec61966-2-1 -color_range tv";
        let codec = match self {
            Self::Webm => "-c:v libvpx-vp9 -crf 20 -b:v 0 -row-mt 0 -f webm",
            _ => "-c:v libx264 -crf 16 -preset medium -tune animation -movflags +faststart -f mp4",
        };
        let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        let mut arguments = words(&input);
        arguments.extend(["-vf".into(), even.into()]);
        arguments.extend(words(tags));
        arguments.extend(words(codec));
        arguments.extend(words("-threads 1 -fflags +bitexact -flags:v +bitexact -metadata"));
        arguments.push(format!("comment={recipe}"));
        arguments
    }
}

/// Runs the encoder on the frames.
fn encode(mut command: Command, frames: &dyn Pictures, path: &Path, run: &Run) -> Result<()> {
    let fail = |why: String| Error::output(path.display().to_string(), why);
    command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|e| fail(format!("ffmpeg: {}", reason(&e))))?;
    // Someone must listen while frames are given, or a talkative encoder waits forever.
    let pipe = child.stderr.take();
    let listener = std::thread::spawn(move || {
        let mut said = String::new();
        // What cannot be read is not told.
        let _ = pipe.map(|mut pipe| pipe.read_to_string(&mut said));
        said
    });
    let fed = feed(&mut child, frames, run);
    if fed == Err(Error::Cancelled) {
        // It may have been stopped by the same key.
        let _ = child.kill();
    }
    let status = child.wait().map_err(|e| fail(format!("ffmpeg: {}", reason(&e))))?;
    let said = listener.join().unwrap_or_default();
    fed?;
    run.check()?;
    if status.success() {
        return Ok(());
    }
    let line = said.lines().rfind(|l| !l.trim().is_empty()).unwrap_or("it says nothing");
    Err(fail(format!(
        "ffmpeg gave up ({}); an .apng or a .gif needs no other program",
        line.trim()
    )))
}

/// Gives the frames to the encoder. One that ends early tells by itself why.
fn feed(child: &mut Child, frames: &dyn Pictures, run: &Run) -> Result<()> {
    let Some(mut pipe) = child.stdin.take() else { return Ok(()) };
    for k in 0..frames.count() {
        run.check()?;
        let rows: Vec<u8> =
            frames.picture(k).pixels().iter().flat_map(|p| over_white(*p)).collect();
        if pipe.write_all(&rows).is_err() {
            break;
        }
    }
    Ok(())
}

fn over_white([r, g, b, a]: [u8; 4]) -> [u8; 3] {
    let a = u32::from(a);
    [r, g, b].map(|v| ((u32::from(v) * a + 255 * (255 - a) + 127) / 255) as u8)
}

/// The program, if a folder of the PATH has it.
fn ffmpeg() -> Option<PathBuf> {
    let name = format!("ffmpeg{}", std::env::consts::EXE_SUFFIX);
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join(&name)).find(|file| file.is_file())
}

fn no_ffmpeg(path: &Path) -> Error {
    let range = "an .apng or a .gif, or a frame a file, since there is no ffmpeg on the PATH";
    Error::setting("-o", path.display(), range)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clear_pixels_are_white_paper() {
        assert_eq!(over_white([10, 20, 30, 255]), [10, 20, 30]);
        assert_eq!(over_white([10, 20, 30, 0]), [255; 3]);
        assert_eq!(over_white([0, 0, 0, 128]), [127; 3]);
    }

    #[test]
    fn arguments_hold_the_recipe_in_one_piece() {
        let frames = vec![chiaro_image::Plane::filled(9, 5, [0; 4])];
        let recipe = "size = 9x5; style = ink";
        let arguments = Container::Mp4.arguments(&Movie { frames: &frames, fps: 23.976, recipe });
        assert_eq!(arguments.last().unwrap(), "comment=size = 9x5; style = ink");
        assert!(arguments.windows(2).any(|w| w == ["-s", "9x5"]));
        assert!(arguments.windows(2).any(|w| w == ["-r", "23.976"]));
    }
}
