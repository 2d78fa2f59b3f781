//! Stacks as `.npz` archives that NumPy reads.

use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use npyz::{AutoSerialize, Deserialize, NpyFile, Order, WriterBuilder};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::stack::FacingBits;
use crate::{LightFrame, RenderError, ShadowMapStack};

/// Newest version of the arrays and of what they mean. It grows when an older reader would misunderstand a file.
const VERSION: u32 = 2;

/// What is written without opacities, which the first version does not know.
const OPAQUE_VERSION: u32 = 1;

impl ShadowMapStack {
    /// Writes the stack as an uncompressed `.npz` archive with these arrays (n fragments):
    ///
    /// | name | type | shape |
    /// |---|---|---|
    /// | `version` | `uint32`, 2 with opacities, else 1 | scalar |
    /// | `width`, `height` | `uint32` | scalar |
    /// | `offsets` | `uint32` | `width * height + 1` |
    /// | `depths` | `float32` | n |
    /// | `gradients` | `float32` | n x 2 |
    /// | `light_facing` | `uint8` | n / 8 rounded up: `np.unpackbits(light_facing, count=n, bitorder="little")` |
    /// | `opacities` | `float32` | n; absent where all are 1 |
    ///
    /// The same stack gives the same bytes. They go to a temporary file beside `path`, which takes its name only when
    /// complete; an existing file is replaced.
    ///
    /// # Errors
    /// [`RenderError::InvalidStack`] or [`RenderError::MapSize`] if the stack violates its invariants,
    /// [`RenderError::File`] if writing fails; no partial file is left.
    pub fn save(&self, path: &Path) -> Result<(), RenderError> {
        self.save_seen_by(path, None)
    }

    /// The same with the frame that the stack was rendered in, in further arrays of `float64` that readers may pass over:
    ///
    /// | name | shape | |
    /// |---|---|---|
    /// | `light_right`, `light_down`, `light_forward` | 3 | world directions of growing texel x, texel y and depth |
    /// | `light_eye` | 3 | where a local light's map is seen from; absent for light from infinity |
    /// | `light_texels_per_unit`, `light_origin_texel` | 2 | see [`LightFrame`] |
    /// | `light_near`, `light_depth_range` | scalar | see [`LightFrame`] |
    ///
    /// # Errors
    /// As [`ShadowMapStack::save`].
    pub fn save_seen_by(&self, path: &Path, frame: Option<&LightFrame>) -> Result<(), RenderError> {
        self.validate()?;
        let fail = |source| RenderError::File { path: path.to_owned(), source };
        let name = path.file_name().ok_or_else(|| fail(io::ErrorKind::InvalidInput.into()))?;
        let mut partial_name = std::ffi::OsString::from(".");
        partial_name.push(name);
        // Unique among processes and threads that may save to the same place.
        static SAVES: AtomicU64 = AtomicU64::new(0);
        let save = SAVES.fetch_add(1, Ordering::Relaxed);
        partial_name.push(format!(".{}-{save}.partial", std::process::id()));
        let partial = path.with_file_name(partial_name);
        let written = self.write_archive(&partial, frame).and_then(|()| fs::rename(&partial, path));
        written.map_err(|error| {
            // The first failure is the one to report; without the file there is nothing to remove.
            let _ = fs::remove_file(&partial);
            fail(error)
        })
    }

    fn write_archive(&self, path: &Path, frame: Option<&LightFrame>) -> io::Result<()> {
        let mut zip = ZipWriter::new(File::create(path)?);
        match self.write_arrays(&mut zip, frame) {
            Ok(()) => zip.finish()?.sync_all(),
            Err(error) => {
                // Dropped, it would try to complete the archive and complain on standard error.
                std::mem::forget(zip);
                Err(error)
            }
        }
    }

    fn write_arrays(&self, zip: &mut ZipWriter<File>, frame: Option<&LightFrame>) -> io::Result<()> {
        let fragments = self.fragments() as u64;
        let version = if self.opacities.is_empty() { OPAQUE_VERSION } else { VERSION };
        write_array(zip, "version", &[], [version])?;
        write_array(zip, "width", &[], [self.width])?;
        write_array(zip, "height", &[], [self.height])?;
        write_array(zip, "offsets", &[self.offsets.len() as u64], self.offsets.iter().copied())?;
        write_array(zip, "depths", &[fragments], self.depths.iter().copied())?;
        write_array(zip, "gradients", &[fragments, 2], self.gradients.iter().flatten().copied())?;
        let bytes = self.light_facing.words.iter().flat_map(|word| word.to_le_bytes());
        let bytes_used = fragments.div_ceil(8);
        write_array(zip, "light_facing", &[bytes_used], bytes.take(bytes_used as usize))?;
        if !self.opacities.is_empty() {
            write_array(zip, "opacities", &[fragments], self.opacities.iter().copied())?;
        }
        if let Some(frame) = frame {
            write_frame(zip, frame)?;
        }
        Ok(())
    }

    /// Reads an archive written by [`ShadowMapStack::save`] or by `np.savez` or `np.savez_compressed` with the same
    /// names and types; `width` and `height` may be any integers. An archive without `version` counts as of the newest one;
    /// one of version 1 has no opacities. Fragments whose opacity is 0 are dropped. Further arrays are ignored.
    ///
    /// # Errors
    /// [`RenderError::File`] if the file cannot be opened, [`RenderError::Archive`] if it is no archive, lacks an
    /// array, is of another version, or an array has the wrong type or is damaged, [`RenderError::InvalidStack`] and
    /// [`RenderError::MapSize`] for contents that violate an invariant.
    pub fn load(path: &Path) -> Result<Self, RenderError> {
        let file = File::open(path).map_err(|source| RenderError::File { path: path.to_owned(), source })?;
        let archive = |what| RenderError::Archive { path: path.to_owned(), what };
        let zip =
            ZipArchive::new(BufReader::new(file)).map_err(|e| archive(format!("no .npz archive: {e}")))?;
        let mut reader = Reader { zip, path: path.to_owned() };
        let version = if reader.has("version") { reader.integer("version")? } else { VERSION };
        if !(OPAQUE_VERSION..=VERSION).contains(&version) {
            let known = format!("this program reads versions {OPAQUE_VERSION} to {VERSION}");
            return Err(archive(format!("array 'version' holds {version}, {known}")));
        }
        let (width, height) = (reader.integer("width")?, reader.integer("height")?);
        crate::light_frame::check_size(width, height)?;
        let offsets = reader.array::<u32>("offsets", "uint32", 1)?;
        let depths = reader.array::<f32>("depths", "float32", 1)?;
        let gradients = reader.array::<f32>("gradients", "float32", 2)?;
        let gradients: Vec<[f32; 2]> = gradients.as_chunks().0.to_vec();
        let bytes = reader.array::<u8>("light_facing", "uint8", 1)?;
        let len = depths.len();
        if bytes.len() != len.div_ceil(8) {
            let what = format!("has {} bytes for {len} depths", bytes.len());
            return Err(RenderError::InvalidStack { array: "light_facing", what });
        }
        let light_facing = (0..len).map(|i| bytes[i / 8] >> (i % 8) & 1 == 1).collect::<FacingBits>();
        let with_opacities = version == VERSION && reader.has("opacities");
        let opacities =
            if with_opacities { reader.array::<f32>("opacities", "float32", 1)? } else { Vec::new() };
        if with_opacities && opacities.len() != len {
            let what = format!("has {} values for {len} depths", opacities.len());
            return Err(RenderError::InvalidStack { array: "opacities", what });
        }
        let stack = Self { width, height, offsets, depths, gradients, light_facing, opacities };
        stack.validate()?;
        Ok(stack.settled())
    }
}

fn write_frame(zip: &mut ZipWriter<File>, frame: &LightFrame) -> io::Result<()> {
    let axes = [("right", frame.right), ("down", frame.down), ("forward", frame.forward)];
    for (name, axis) in axes.into_iter().chain(frame.eye.map(|eye| ("eye", eye))) {
        write_array(zip, &format!("light_{name}"), &[3], axis)?;
    }
    write_array(zip, "light_texels_per_unit", &[2], frame.texels_per_unit)?;
    write_array(zip, "light_origin_texel", &[2], frame.origin_texel)?;
    write_array(zip, "light_near", &[], [frame.near])?;
    write_array(zip, "light_depth_range", &[], [frame.depth_range])
}

/// Adds an array of a shape, row by row, to an uncompressed `.npz` archive.
///
/// # Errors
/// What the system says where writing fails.
pub fn write_array<T: AutoSerialize>(
    zip: &mut ZipWriter<impl Write + Seek>,
    name: &str,
    shape: &[u64],
    values: impl IntoIterator<Item = T>,
) -> io::Result<()> {
    // Sizes beyond 4 GiB need the larger headers, which every reader of today understands.
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true);
    zip.start_file(npyz::npz::file_name_from_array_name(name), options)?;
    // The archive computes a checksum per write: single values would be slow.
    let mut buffer = BufWriter::with_capacity(1 << 18, zip);
    let mut array = npyz::WriteOptions::new().default_dtype().shape(shape).writer(&mut buffer).begin_nd()?;
    array.extend(values)?;
    array.finish()?;
    buffer.flush()
}

struct Reader<R> {
    zip: ZipArchive<R>,
    path: PathBuf,
}

impl<R: Read + Seek> Reader<R> {
    fn has(&self, name: &str) -> bool {
        self.zip.index_for_name(&npyz::npz::file_name_from_array_name(name)).is_some()
    }

    /// Opens an array and returns it with the number of bytes its archive entry declares.
    fn open(&mut self, name: &str) -> Result<(NpyFile<impl Read>, u64), RenderError> {
        let path = &self.path;
        let fail = |what| RenderError::Archive { path: path.clone(), what };
        let entry = self
            .zip
            .by_name(&npyz::npz::file_name_from_array_name(name))
            .map_err(|e| fail(format!("array '{name}': {e}")))?;
        let size = entry.size();
        let npy = NpyFile::new(BufReader::with_capacity(1 << 18, entry))
            .map_err(|e| fail(format!("array '{name}': {e}")))?;
        Ok((npy, size))
    }

    fn array<T: Deserialize>(
        &mut self,
        name: &'static str,
        dtype: &str,
        dimensions: usize,
    ) -> Result<Vec<T>, RenderError> {
        let path = self.path.clone();
        let fail = |what: String| RenderError::Archive {
            path: path.clone(),
            what: format!("array '{name}' {what}"),
        };
        let (npy, size) = self.open(name)?;
        let shape = npy.shape().to_vec();
        let fits = match dimensions {
            2 => shape.len() == 2 && shape[1] == 2 && npy.order() == Order::C,
            n => shape.len() == n,
        };
        if !fits {
            return Err(fail(format!("has shape {shape:?}")));
        }
        // A damaged header must not decide how much is allocated.
        let declared = shape.iter().try_fold(1u64, |product, n| product.checked_mul(*n));
        if declared.is_none_or(|n| n.checked_mul(size_of::<T>() as u64).is_none_or(|bytes| bytes > size)) {
            return Err(fail(format!("has shape {shape:?} but only {size} bytes")));
        }
        let found = npy.dtype().descr();
        let values = npy.data::<T>().map_err(|_| fail(format!("has type {found} instead of {dtype}")))?;
        let values: io::Result<Vec<T>> = values.collect();
        values.map_err(|e| fail(format!("is damaged: {e}")))
    }

    fn integer(&mut self, name: &'static str) -> Result<u32, RenderError> {
        let path = self.path.clone();
        let fail = |what: String| RenderError::Archive {
            path: path.clone(),
            what: format!("array '{name}' {what}"),
        };
        let (npy, _) = self.open(name)?;
        if !npy.shape().is_empty() {
            return Err(fail(format!("has shape {:?} instead of being a scalar", npy.shape())));
        }
        let found = npy.dtype().descr();
        let value = match npy.try_data::<u32>() {
            Ok(values) => first(values),
            Err(npy) => match npy.try_data::<i64>() {
                Ok(values) => first(values),
                Err(npy) => match npy.try_data::<i32>() {
                    Ok(values) => first(values),
                    Err(npy) => npy.try_data::<u64>().ok().and_then(first),
                },
            },
        };
        value
            .and_then(|v| u32::try_from(v).ok())
            .ok_or_else(|| fail(format!("of type {found} holds no size")))
    }
}

fn first<T: Into<i128>>(mut values: impl Iterator<Item = io::Result<T>>) -> Option<i128> {
    values.next()?.ok().map(Into::into)
}
