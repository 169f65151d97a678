//! The user's input, in SI: scene file, groom, checks, initial state. No GPU.
//!
//! Data flows one way: text or code → [`Scene`] → [`CheckedScene`] (every value, in range; see [`keys`]) →
//! [`InitialState`] (arrays).

mod added_mass;
mod air;
mod assign;
mod atomic;
mod body;
mod box_fit;
mod change;
mod counts;
mod curves;
mod declare;
pub mod derived;
mod document;
mod error;
mod faults;
mod filter_limits;
mod force;
mod frames;
mod groom;
mod hair;
mod initial;
mod inverse_statics;
pub mod keys;
pub mod limits;
mod load;
mod mesh;
mod motion;
mod picture;
mod pins;
mod reader;
mod scatter;
mod scene;
mod schema;
mod solid;
mod strand;
mod strands;
mod triangles;
mod units;
mod variants;
mod warnings;
mod wind;
mod write;

pub use atomic::{AtomicFile, remove};
pub use body::{Body, Capsule, CheckedBody, CheckedShape, Round, Shape, Sphere};
pub use change::{Assignments, Change, is_fixed};
pub use counts::Counts;
pub use curves::{Curves, Dropped, GroomFormat, npy_head};
pub use error::{SceneError, spelled};
pub use filter_limits::Excess;
pub use force::{CheckedForce, Force, ForceField, Strength};
pub use frames::{Bond, Frames, Phase};
pub use groom::{Groom, PerStrand, RestCurvature, RestShape};
pub use initial::{AirParticles, InitialState};
pub use load::Outline;
pub use motion::{Keyframe, Motion, Pose};
pub use picture::*;
pub use pins::{Pin, Pinned, Ring, around};
pub use scene::*;
pub use schema::schema;
pub use solid::{MeshFile, Solid};
pub use strands::{End, Ends, Strands};
pub use triangles::{DistanceGrid, Lattice, Part, Triangles};
pub use warnings::Warning;
pub use wind::InflowWave;
