//! The bytes behind the buffers of a document, loaded only where geometry needs them.

use std::fs::File;
use std::io::{self, Read as _};
use std::ops::{Deref, Range};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gltf::json::Root;
use percent_encoding::percent_decode_str;

/// Most bytes of all buffers from files together: more than the greatest supported scene needs. A document may name a
/// file of any size, and any number of times.
const MAX_FILE_BYTES: u64 = 1 << 32;

/// A part of shared bytes.
#[derive(Clone, Default)]
pub(super) struct Bytes {
    all: Arc<Vec<u8>>,
    range: Range<usize>,
}

impl From<Vec<u8>> for Bytes {
    fn from(all: Vec<u8>) -> Self {
        Self { range: 0..all.len(), all: Arc::new(all) }
    }
}

impl Deref for Bytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        self.all.get(self.range.clone()).unwrap_or(&[])
    }
}

/// Loads buffers; one that only images or animations that are not played use is never loaded.
pub(super) struct Buffers<'a> {
    base_dir: Option<&'a Path>,
    /// The binary chunk.
    blob: Option<Bytes>,
    /// Buffers by index; empty ones that were not loaded.
    loaded: Vec<Option<Bytes>>,
    /// Bytes that came from files.
    file_bytes: u64,
}

impl<'a> Buffers<'a> {
    /// No buffer is loaded yet. `base_dir` is where relative files are looked for, `chunk` is the binary one of `file`.
    pub(super) fn new(base_dir: Option<&'a Path>, file: Bytes, chunk: Option<Range<usize>>, count: usize) -> Self {
        let blob = chunk.map(|range| Bytes { range, ..file });
        Self { base_dir, blob, loaded: vec![None; count], file_bytes: 0 }
    }

    /// What was loaded, by index; empty what was not.
    pub(super) fn finish(self) -> Vec<Bytes> {
        self.loaded.into_iter().map(Option::unwrap_or_default).collect()
    }

    /// Loads buffer `index` of `root`, exactly as many bytes as the document says.
    pub(super) fn load(&mut self, root: &Root, index: usize) -> Result<(), String> {
        let Some(buffer) = root.buffers.get(index) else {
            return Err(format!("there is no buffers[{index}]; export the file again"));
        };
        if self.loaded.get(index).is_none_or(Option::is_some) {
            return Ok(());
        }
        let wanted = buffer.byte_length.0;
        let mut bytes = match (&buffer.uri, &self.blob) {
            (None, Some(blob)) if index == 0 => blob.clone(),
            (None, _) => {
                return Err(format!(
                    "buffers[{index}] has no uri and the file holds no binary chunk for it; export the file again"
                ));
            }
            (Some(uri), _) => self.read_uri(index, uri, wanted)?.into(),
        };
        let length = usize::try_from(wanted).unwrap_or(usize::MAX);
        if bytes.len() < length {
            return Err(format!(
                "buffers[{index}] is too short: the document says {wanted} bytes and there are {}; export or download the file again",
                bytes.len()
            ));
        }
        bytes.range.end = bytes.range.start + length;
        self.loaded[index] = Some(bytes);
        Ok(())
    }

    fn read_uri(&mut self, index: usize, uri: &str, wanted: u64) -> Result<Vec<u8>, String> {
        if has_scheme(uri, "data") {
            let broken = |problem: String| {
                format!("the data uri of buffers[{index}] is broken ({problem}); export the file again")
            };
            let data = data_url::DataUrl::process(uri).map_err(|error| broken(error.to_string()))?;
            return data.decode_to_vec().map(|(bytes, _)| bytes).map_err(|error| broken(error.to_string()));
        }
        let relative = if has_scheme(uri, "file") {
            let path = &uri["file:".len()..];
            path.strip_prefix("//").unwrap_or(path)
        } else if let Some((scheme, _)) = uri.split_once("://") {
            return Err(format!(
                "buffers[{index}] is at a {scheme} address, and nothing is downloaded; save it beside the scene, or export as .glb"
            ));
        } else {
            uri
        };
        let decoded = percent_decode_str(relative)
            .decode_utf8()
            .map_err(|_| format!("the uri of buffers[{index}] is not UTF-8 after percent-decoding; rename the file"))?;
        let mut path = self.locate(index, Path::new(decoded.as_ref()))?;
        if decoded != relative && !path.exists() {
            // Some exporters write file names as they are.
            let raw = self.locate(index, Path::new(relative))?;
            if raw.exists() {
                path = raw;
            }
        }
        let bytes = read_file(&path, wanted, MAX_FILE_BYTES.saturating_sub(self.file_bytes)).map_err(|error| {
            format!(
                "buffers[{index}] is in file '{}', which cannot be read: {error}; put it there, or export as .glb, which holds everything",
                path.display()
            )
        })?;
        self.file_bytes += bytes.len() as u64;
        Ok(bytes)
    }

    fn locate(&self, index: usize, path: &Path) -> Result<PathBuf, String> {
        match self.base_dir {
            _ if path.is_absolute() => Ok(path.to_owned()),
            Some(base) => Ok(base.join(path)),
            None => Err(format!(
                "buffers[{index}] is in file '{}', and a scene given as bytes has no folder to look in; give the folder, or export as .glb",
                path.display()
            )),
        }
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
