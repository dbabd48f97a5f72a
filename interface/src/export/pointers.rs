//! Memory that importers pass to functions of C.
#![allow(unsafe_code)] // C calls it

use super::ExportError;

/// The numbers at `pointer`.
///
/// # Safety
/// A pointer that is neither null nor misaligned points to `length` values that live during the call.
pub(super) unsafe fn slice<'a, T>(
    call: &'static str,
    argument: &'static str,
    pointer: *const T,
    length: usize,
) -> Result<&'a [T], ExportError> {
    if length == 0 {
        return Ok(&[]);
    }
    let possible = length.checked_mul(size_of::<T>()).is_some_and(|bytes| bytes <= isize::MAX as usize);
    if pointer.is_null() || !pointer.is_aligned() || !possible {
        return Err(ExportError::Pointer { call, argument });
    }
    // SAFETY: by the caller; checked as far as it can be.
    Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// The numbers at `pointer`, mutable.
///
/// # Safety
/// As [`slice`]; in addition, nothing else uses the values during the call.
pub(super) unsafe fn slice_mut<'a, T>(
    call: &'static str,
    argument: &'static str,
    pointer: *mut T,
    length: usize,
) -> Result<&'a mut [T], ExportError> {
    // SAFETY: by the caller.
    let checked = unsafe { slice(call, argument, pointer.cast_const(), length) }?;
    if checked.is_empty() {
        return Ok(&mut []);
    }
    // SAFETY: as above.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, length) })
}

/// The value at `pointer`.
///
/// # Safety
/// As [`slice_mut`].
pub(super) unsafe fn place<'a, T>(
    call: &'static str,
    argument: &'static str,
    pointer: *mut T,
) -> Result<&'a mut T, ExportError> {
    // SAFETY: by the caller.
    let places = unsafe { slice_mut(call, argument, pointer, 1) }?;
    places.first_mut().ok_or(ExportError::Pointer { call, argument })
}
