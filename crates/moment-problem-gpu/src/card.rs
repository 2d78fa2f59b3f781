//! The device, and what may keep it from solving programs.

use crate::programs::Programs;
use crate::resident::ResidentPrograms;
use crate::shader::{self, Options};
use graphics_device::{DeviceError, GraphicsDevice};
use wgpu::Features;

/// Why programs cannot be solved on a card.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CardError {
    /// The device itself.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// It computes in single precision only.
    #[error("{0} has no double precision (SHADER_F64)")]
    NoDoubles(String),
    /// Something does not fit.
    #[error("{what}: {wanted} are more than {most}, which {adapter} has or this crate serves")]
    TooLarge {
        /// What.
        what: &'static str,
        /// How much of it is wanted.
        wanted: u64,
        /// How much there is.
        most: u64,
        /// The adapter's name.
        adapter: String,
    },
    /// More programs than there is room for were left uncertified.
    #[error("{adapter}: {left} of {programs} programs were not certified, room is for {room}")]
    Uncertified {
        /// Programs left.
        left: usize,
        /// All programs.
        programs: usize,
        /// Room for them.
        room: usize,
        /// The adapter's name.
        adapter: String,
    },
}

/// A device with double precision.
pub struct Card {
    pub(crate) gpu: GraphicsDevice,
    pub(crate) subgroups: bool,
    checked: bool,
}

impl Card {
    /// The best adapter. `checked`: shaders check every index at run time, for tests; otherwise they rely on what the shader
    /// proves.
    ///
    /// # Errors
    /// [`CardError::Device`] without an adapter, [`CardError::NoDoubles`] for one without double precision.
    pub fn open(checked: bool) -> Result<Self, CardError> {
        Self::with(checked, true)
    }

    /// The same, without counting in subgroups unless they are wanted.
    ///
    /// # Errors
    /// As [`Card::open`].
    pub fn with(checked: bool, subgroups: bool) -> Result<Self, CardError> {
        let wanted = Features::SHADER_F64 | Features::SUBGROUP | Features::TIMESTAMP_QUERY;
        let gpu = GraphicsDevice::open_whole(wanted)?;
        let features = gpu.device.features();
        if !features.contains(Features::SHADER_F64) {
            return Err(CardError::NoDoubles(gpu.name.to_string()));
        }
        let subgroups = subgroups && features.contains(Features::SUBGROUP);
        Ok(Self { gpu, subgroups, checked })
    }

    /// What it runs on.
    pub fn name(&self) -> String {
        self.gpu.name.to_string()
    }

    /// Whether the adapter runs on the CPU.
    pub fn is_software(&self) -> bool {
        self.gpu.software
    }

    pub(crate) fn module(&self, options: Options) -> wgpu::ShaderModule {
        let source = shader::source(options);
        if self.checked {
            return self.gpu.shader(&source);
        }
        // SAFETY: columns are kept in 0..depths where they arise, and every loop over them ends; buffer indices are below
        // programs, candidates and stride, for which the buffers were made. The checked module is compared in tests.
        unsafe { self.gpu.shader_unchecked(&source) }
    }

    /// Puts programs on the card, with room for so many candidates at a time. Programs that are `shared` with lend their room
    /// for what lies between the stages, if it is large enough: work follows work on a card.
    ///
    /// # Errors
    /// [`CardError::TooLarge`] where memory or the size of a binding does not suffice, [`CardError::Device`] where the device
    /// fails.
    ///
    /// # Panics
    /// If the order names a program that does not exist, or the starts are for another rank than five.
    pub fn upload(
        &self,
        programs: Programs<'_>,
        candidates: usize,
        shared: Option<&ResidentPrograms<'_>>,
    ) -> Result<ResidentPrograms<'_>, CardError> {
        self.gpu.watched(|| ResidentPrograms::new(self, programs, candidates, shared))
    }
}
