//! The bytes behind the buffers of a document, loaded only where geometry needs them.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use gltf::json::Root;
use percent_encoding::percent_decode_str;

use crate::error::SceneError;

/// Most bytes of all buffers from files together: more than the greatest supported scene needs. A document may name a
/// file of any size, and any number of times.
const MAX_FILE_BYTES: u64 = 1 << 32;

/// The bytes of the buffers that were loaded, by index.
pub(super) struct Bytes<'a>(Vec<Option<Cow<'a, [u8]>>>);

impl Bytes<'_> {
    /// The bytes of a buffer that was loaded; empty for any other.
    pub(super) fn of(&self, buffer: usize) -> &[u8] {
        self.0.get(buffer).and_then(Option::as_deref).unwrap_or(&[])
    }

    /// The same for longer than the file's own bytes live: what was borrowed from them is copied.
    pub(super) fn into_owned(self) -> Bytes<'static> {
        Bytes(self.0.into_iter().map(|bytes| bytes.map(|bytes| Cow::Owned(bytes.into_owned()))).collect())
    }
}

/// Loads buffers; one that only images or animations that are not played use is never loaded.
pub(super) struct Buffers<'a> {
    scene: &'a str,
    base_dir: Option<&'a Path>,
    blob: Option<&'a [u8]>,
    loaded: Vec<Option<Cow<'a, [u8]>>>,
    /// Bytes that came from files.
    file_bytes: u64,
}

impl<'a> Buffers<'a> {
    /// No buffer is loaded yet. `base_dir` is where relative files are looked for.
    pub(super) fn new(scene: &'a str, base_dir: Option<&'a Path>, blob: Option<&'a [u8]>, count: usize) -> Self {
        Self { scene, base_dir, blob, loaded: vec![None; count], file_bytes: 0 }
    }

    /// What was loaded.
    pub(super) fn finish(self) -> Bytes<'a> {
        Bytes(self.loaded)
    }

    /// Loads buffer `index` of `root`, exactly as many bytes as the document says.
    pub(super) fn load(&mut self, root: &Root, index: usize) -> Result<(), SceneError> {
        let Some(buffer) = root.buffers.get(index) else {
            return Err(self.invalid(format!("there is no buffers[{index}]; export the file again")));
        };
        if self.loaded.get(index).is_none_or(Option::is_some) {
            return Ok(());
        }
        let wanted = buffer.byte_length.0;
        let mut bytes = match &buffer.uri {
            None if index == 0 && self.blob.is_some() => Cow::Borrowed(self.blob.unwrap_or_default()),
            None => {
                return Err(self.invalid(format!(
                    "buffers[{index}] has no uri and the file holds no binary chunk for it; export the file again"
                )));
            }
            Some(uri) => Cow::Owned(self.read_uri(index, uri, wanted)?),
        };
        let length = usize::try_from(wanted).unwrap_or(usize::MAX);
        if bytes.len() < length {
            return Err(self.invalid(format!(
                "buffers[{index}] is too short: the document says {wanted} bytes and there are {}; export or download the file again",
                bytes.len()
            )));
        }
        match &mut bytes {
            Cow::Borrowed(bytes) => *bytes = &bytes[..length],
            Cow::Owned(bytes) => bytes.truncate(length),
        }
        self.loaded[index] = Some(bytes);
        Ok(())
    }

    fn read_uri(&mut self, index: usize, uri: &str, wanted: u64) -> Result<Vec<u8>, SceneError> {
        if has_scheme(uri, "data") {
            return self.decode_data(index, uri);
        }
        let relative = if has_scheme(uri, "file") {
            let path = &uri["file:".len()..];
            path.strip_prefix("//").unwrap_or(path)
        } else if let Some((scheme, _)) = uri.split_once("://") {
            return Err(self.invalid(format!(
                "buffers[{index}] is at a {scheme} address, and nothing is downloaded; save it beside the scene, or export as .glb"
            )));
        } else {
            uri
        };
        let decoded = percent_decode_str(relative).decode_utf8().map_err(|_| {
            self.invalid(format!("the uri of buffers[{index}] is not UTF-8 after percent-decoding; rename the file"))
        })?;
        let mut path = self.locate(index, Path::new(decoded.as_ref()))?;
        if decoded != relative && !path.exists() {
            // Some exporters write file names as they are.
            let raw = self.locate(index, Path::new(relative))?;
            if raw.exists() {
                path = raw;
            }
        }
        match read_file(&path, wanted, MAX_FILE_BYTES.saturating_sub(self.file_bytes)) {
            Ok(bytes) => {
                self.file_bytes += bytes.len() as u64;
                Ok(bytes)
            }
            Err(source) => Err(SceneError::ReadBuffer { scene: self.scene.to_owned(), buffer: index, path, source }),
        }
    }

    fn decode_data(&self, index: usize, uri: &str) -> Result<Vec<u8>, SceneError> {
        let broken = |problem: String| {
            self.invalid(format!("the data uri of buffers[{index}] is broken ({problem}); export the file again"))
        };
        let data = data_url::DataUrl::process(uri).map_err(|error| broken(error.to_string()))?;
        let (bytes, _) = data.decode_to_vec().map_err(|error| broken(error.to_string()))?;
        Ok(bytes)
    }

    fn locate(&self, index: usize, path: &Path) -> Result<PathBuf, SceneError> {
        if path.is_absolute() {
            return Ok(path.to_owned());
        }
        match self.base_dir {
            Some(base) => Ok(base.join(path)),
            None => Err(self.invalid(format!(
                "buffers[{index}] is in file '{}', and a scene given as bytes has no folder to look in; give the folder, or export as .glb",
                path.display()
            ))),
        }
    }

    fn invalid(&self, problem: String) -> SceneError {
        SceneError::Invalid { scene: self.scene.to_owned(), problem }
    }
}

fn has_scheme(uri: &str, scheme: &str) -> bool {
    uri.split_once(':').is_some_and(|(head, _)| head.eq_ignore_ascii_case(scheme))
}

/// Reads at most `wanted` bytes of a regular file: a document may name a device or a pipe, which never ends. Refuses more
/// than `most` bytes.
fn read_file(path: &Path, wanted: u64, most: u64) -> io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    if !metadata.is_file() {
        return Err(io::Error::other("it is not a regular file"));
    }
    if wanted.min(metadata.len()) > most {
        return Err(io::Error::other(format!("all buffers together have more than {MAX_FILE_BYTES} bytes")));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(wanted.min(most)).read_to_end(&mut bytes)?;
    Ok(bytes)
}
