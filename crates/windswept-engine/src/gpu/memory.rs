//! The buffers behind [`State`]'s descriptions: allocated after a check, written and read as plain data.

use std::{
    collections::HashMap,
    num::NonZero,
    sync::{Mutex, PoisonError, mpsc},
};

use bytemuck::Pod;

use windswept_shaders::{BufferKind, TEXTURE_ROW};

use crate::{
    aliasing::Aliasing,
    array::{AnyArray, Array, Lifetime, is_uniform},
    error::GpuError,
    gpu::Gpu,
    state::State,
    textures,
};

/// Size of a row of a uniform, four words \[bytes\].
const UNIFORM_ROW: u64 = 16;

/// A buffer for each block of memory, and which array lies in which block.
#[derive(Debug)]
pub(crate) struct Memory {
    buffers: Vec<wgpu::Buffer>,
    aliasing: Aliasing,
    /// Textures by their numbers in `aliasing`, each made when a program first reads it.
    textures: Mutex<HashMap<usize, wgpu::Texture>>,
    /// Rows of each of those, made or not.
    rows: Vec<u64>,
}

impl Memory {
    /// Allocates everything, zeroed, after checking each size.
    pub(crate) fn new(gpu: &Gpu, state: &State, aliasing: Aliasing) -> Result<Self, GpuError> {
        let arrays = state.arrays();
        check_sizes(gpu, &arrays)?;
        let buffers = aliasing.largest(&arrays).iter().map(|array| allocate(gpu, array)).collect::<Result<_, _>>()?;
        let mut rows = vec![0; arrays.len()];
        for array in &arrays {
            let rows = &mut rows[aliasing.texture(array)];
            *rows = textures::rows(array).max(*rows);
        }
        Ok(Self { buffers, aliasing, textures: Mutex::default(), rows })
    }

    /// Which array lies in which block.
    pub(crate) fn aliasing(&self) -> &Aliasing {
        &self.aliasing
    }

    /// Gives an array that has grown, and lies alone, a new, zeroed buffer.
    pub(crate) fn reallocate(&mut self, gpu: &Gpu, array: &AnyArray) -> Result<(), GpuError> {
        self.buffers[self.aliasing.block(array)] = allocate(gpu, array)?;
        let texture = self.aliasing.texture(array);
        if textures::rows(array) > self.rows[texture] {
            self.rows[texture] = textures::rows(array);
            self.textures.get_mut().unwrap_or_else(PoisonError::into_inner).remove(&texture);
        }
        Ok(())
    }

    pub(crate) fn buffer(&self, array: &AnyArray) -> &wgpu::Buffer {
        &self.buffers[self.aliasing.block(array)]
    }

    /// The binding of an array: the whole of it, or one element. Its buffer may be longer, and a uniform is whole rows.
    pub(crate) fn binding(&self, array: &AnyArray, kind: BufferKind) -> wgpu::BindingResource<'_> {
        let (offset, size) = array.element().map_or((0, array.bytes()), |k| (k * array.stride(), array.size()));
        let size = if kind == BufferKind::Uniform { size.next_multiple_of(UNIFORM_ROW) } else { size };
        let (buffer, size) = (self.buffer(array), NonZero::new(size));
        wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset, size })
    }

    /// Size of all textures together that were made \[bytes\].
    pub(crate) fn texture_bytes(&self) -> u64 {
        let textures = self.textures.lock().unwrap_or_else(PoisonError::into_inner);
        textures.values().map(|texture| u64::from(texture.height()) * u64::from(TEXTURE_ROW)).sum()
    }

    /// The texture of an array, of texels of so many bytes.
    pub(crate) fn texture(&self, gpu: &Gpu, array: &AnyArray, texel: u32) -> Result<wgpu::Texture, GpuError> {
        let mut textures = self.textures.lock().unwrap_or_else(PoisonError::into_inner);
        let number = self.aliasing.texture(array);
        if let Some(texture) = textures.get(&number) {
            return Ok(texture.clone());
        }
        let height = self.rows[number] as u32;
        let texture = gpu.checked(
            || format!("allocating a texture of {height} rows of {TEXTURE_ROW} bytes for {}", array.name()),
            || {
                gpu.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(array.name()),
                    size: wgpu::Extent3d { width: TEXTURE_ROW / texel, height, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: format(texel),
                    usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::STORAGE_BINDING,
                    view_formats: &[],
                })
            },
        )?;
        textures.insert(number, texture.clone());
        Ok(texture)
    }

    /// Replaces elements of an array from `first` on.
    pub(crate) fn write<T: Pod>(&self, gpu: &Gpu, array: &Array<T>, first: usize, data: &[T]) -> Result<(), GpuError> {
        self.write_bytes(gpu, array, first, bytemuck::cast_slice(data))
    }

    /// Replaces elements of an array from `first` on, whatever they are.
    pub(crate) fn write_bytes(&self, gpu: &Gpu, array: &AnyArray, first: usize, bytes: &[u8]) -> Result<(), GpuError> {
        if bytes.is_empty() {
            return Ok(());
        }
        // Uniforms lie apart.
        let apart = array.stride() != array.size();
        let part = if apart { array.size() as usize } else { bytes.len() };
        gpu.checked(
            || format!("writing {}", array.name()),
            || {
                for (k, bytes) in bytes.chunks(part).enumerate() {
                    gpu.queue.write_buffer(self.buffer(array), (first + k) as u64 * array.stride(), bytes);
                }
            },
        )
    }

    /// Reads whole arrays, in one submission.
    pub(crate) fn read<T: Pod>(&self, gpu: &Gpu, arrays: &[AnyArray]) -> Result<Vec<Vec<T>>, GpuError> {
        self.view(gpu, arrays, |views| {
            let elements = |(bytes, array): (&&[u8], &AnyArray)| match array.stride() == array.size() {
                true => bytemuck::pod_collect_to_vec(bytes),
                false => bytes
                    .chunks(array.stride() as usize)
                    .map(|element| bytemuck::pod_read_unaligned(&element[..array.size() as usize]))
                    .collect(),
            };
            views.iter().zip(arrays).map(elements).collect()
        })
    }

    /// Shows `look` the bytes of whole arrays, fetched in one submission, in the memory to which the driver has mapped
    /// them. Scratch that shares its memory with other arrays has nothing to show: an error.
    pub(crate) fn view<R>(
        &self,
        gpu: &Gpu,
        arrays: &[AnyArray],
        look: impl FnOnce(&[&[u8]]) -> R,
    ) -> Result<R, GpuError> {
        for array in arrays {
            if array.life() == Lifetime::Transient && !self.aliasing.is_alone(array) {
                return Err(GpuError::Shared { array: array.name() });
            }
        }
        let sizes: Vec<u64> = arrays.iter().map(|array| array.stride() * array.len()).collect();
        let total: u64 = sizes.iter().sum();
        if total == 0 {
            return Ok(look(&vec![&[][..]; arrays.len()]));
        }
        let doing = || format!("reading {}", arrays.iter().map(|array| array.name()).collect::<Vec<_>>().join(", "));
        let (sender, receiver) = mpsc::channel();
        let staging = gpu.checked(doing, || {
            let staging = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("readback"),
                size: total,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let mut encoder =
                gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("readback") });
            let mut offset = 0;
            for (array, size) in arrays.iter().zip(&sizes) {
                if *size > 0 {
                    encoder.copy_buffer_to_buffer(self.buffer(array), 0, &staging, offset, Some(*size));
                }
                offset += size;
            }
            gpu.queue.submit([encoder.finish()]);
            staging.map_async(wgpu::MapMode::Read, .., move |result| {
                // The receiver is gone only if we returned early.
                let _ = sender.send(result);
            });
            staging
        })?;
        gpu.wait()?;
        let mapped = receiver.recv().map_err(|_| GpuError::Lost("a readback was never answered".to_owned()))?;
        mapped.map_err(|error| GpuError::Lost(format!("{}: {error}", doing())))?;
        let view = staging.get_mapped_range(..).map_err(|error| GpuError::Lost(format!("{}: {error}", doing())))?;
        let mut rest = &view[..];
        let views: Vec<&[u8]> = sizes
            .iter()
            .map(|size| {
                let (bytes, after) = rest.split_at(*size as usize);
                rest = after;
                bytes
            })
            .collect();
        Ok(look(&views))
    }
}

/// The format of texels of so many bytes.
pub(super) fn format(texel: u32) -> wgpu::TextureFormat {
    match texel {
        4 => wgpu::TextureFormat::R32Uint,
        8 => wgpu::TextureFormat::Rg32Uint,
        _ => wgpu::TextureFormat::Rgba32Uint,
    }
}

/// Names the largest of the arrays that are too large: it says how much would fit of what they hold.
pub(crate) fn check_sizes(gpu: &Gpu, arrays: &[AnyArray]) -> Result<(), GpuError> {
    let limit = gpu.largest_binding();
    let largest = arrays.iter().filter(|array| array.bytes() > limit).max_by_key(|array| array.bytes());
    largest.map_or(Ok(()), |array| {
        Err(GpuError::TooLarge { array: array.name(), bytes: array.bytes(), limit, fits: limit / array.stride() })
    })
}

fn allocate(gpu: &Gpu, array: &AnyArray) -> Result<wgpu::Buffer, GpuError> {
    let uniform = is_uniform(array.name());
    let kind = match (uniform, gpu.is_software()) {
        (true, _) => wgpu::BufferUsages::UNIFORM,
        (false, true) => wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE,
        (false, false) => wgpu::BufferUsages::STORAGE,
    };
    gpu.checked(
        || format!("allocating {} bytes for {}", array.bytes(), array.name()),
        || {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(array.name()),
                size: array.bytes().next_multiple_of(UNIFORM_ROW),
                usage: kind | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        },
    )
}
