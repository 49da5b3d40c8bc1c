//! One array a file, in NumPy's format (NEP 1): what its header promises is checked with the file's size before memory is taken.

use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::path::Path;

use bytemuck::NoUninit;
use npyz::{AutoSerialize, Deserialize, NpyFile, NpyHeader, Order};

use super::{ExchangeError, open};

/// The most bytes of a header; NumPy writes 128.
const MAX_HEADER: usize = 1024;

/// The most brackets that a header opens, a dictionary and a tuple: more are types with fields, or a way to nest without end.
const MAX_BRACKETS: usize = 2;

/// The most digits of a header: the product of lengths with so many does not leave 64 bits.
const MAX_DIGITS: usize = 18;

/// The numbers of an array of shape (`rows`,), or (`rows`, `columns`) row after row, in whatever order and order of bytes they are stored.
///
/// # Errors
/// If it cannot be read, is pickled, of another shape or type, or its file has another size than the header promises.
pub fn read<T: Deserialize + AutoSerialize + NoUninit>(
    path: &Path,
    columns: Option<usize>,
    rows: usize,
) -> Result<Vec<T>, ExchangeError> {
    let fail = |source| ExchangeError::Read(path.to_owned(), source);
    let invalid = |problem: String| ExchangeError::invalid(path, problem);
    let (mut file, mut head) = (open(path)?, Vec::new());
    let size = file.metadata().map_err(fail)?.len();
    file.by_ref().take(MAX_HEADER as u64).read_to_end(&mut head).map_err(fail)?;
    // Version 1 has a length of two bytes, later ones have four.
    let begin = if head.get(6) == Some(&1) { 10 } else { 12 };
    let length =
        head.get(8..begin).map(|bytes| bytes.iter().rev().fold(0, |sum, byte| (sum << 8) | usize::from(*byte)));
    let end = begin + length.unwrap_or(MAX_HEADER);
    let text = head
        .get(begin..end)
        .ok_or_else(|| invalid("is no .npy file with a header of at most 1024 bytes".to_owned()))?;
    let count = |of: fn(&&u8) -> bool| text.iter().filter(of).count();
    if count(|byte| b"([{".contains(byte)) > MAX_BRACKETS || count(|byte| byte.is_ascii_digit()) > MAX_DIGITS {
        return Err(invalid(
            "has a header of a type with fields, or of more than any file has: store one plain array".to_owned(),
        ));
    }
    let header = NpyHeader::from_reader(&head[..end])
        .map_err(|error| invalid(format!("is no .npy file that can be read: {error}; store it by numpy.save")))?;
    let shape: Vec<u64> = [Some(rows), columns].into_iter().flatten().map(|length| length as u64).collect();
    if header.uses_pickled_array() {
        return Err(invalid("holds pickled objects, which are never read: store numbers".to_owned()));
    }
    if header.shape() != shape {
        return Err(invalid(format!("has shape {:?} and must have {shape:?}, a row a ray", header.shape())));
    }
    let (found, wanted) = (header.dtype().descr(), T::default_dtype().descr());
    let is_other = |_| invalid(format!("is an array of {found} and must be one of {wanted}"));
    let count = rows * columns.unwrap_or(1);
    if T::reader(&header.dtype()).is_ok() && size != (end + count * size_of::<T>()) as u64 {
        return Err(invalid(format!(
            "has {size} bytes, which is not what its header promises: it is cut off or damaged"
        )));
    }
    file.seek(SeekFrom::Start(end as u64)).map_err(fail)?;
    let order = header.order();
    let data = NpyFile::with_header(header, BufReader::with_capacity(1 << 16, file)).data::<T>().map_err(is_other)?;
    let values = data.collect::<Result<Vec<T>, _>>().map_err(fail)?;
    if let (Order::Fortran, Some(columns)) = (order, columns) {
        return Ok((0..count).map(|at| values[at % columns * rows + at / columns]).collect());
    }
    Ok(values)
}

/// A file of numbers: of shape (N,), or of (N, `columns`) row after row.
pub fn write<T: AutoSerialize + NoUninit>(columns: Option<usize>, values: &[T]) -> Vec<u8> {
    let shape = match columns {
        None => format!("({},)", values.len()),
        Some(columns) => format!("({}, {columns})", values.len() / columns.max(1)),
    };
    let text = format!("{{'descr': {}, 'fortran_order': False, 'shape': {shape}, }}", T::default_dtype().descr());
    // The data begin at a multiple of 64 bytes.
    let width = (10 + text.len() + 1).next_multiple_of(64) - 11;
    let header = format!("{text:width$}\n");
    let length = (header.len() as u16).to_le_bytes();
    [&b"\x93NUMPY\x01\x00"[..], &length, header.as_bytes(), bytemuck::cast_slice(values)].concat()
}
