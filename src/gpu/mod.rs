//! What every GPU pass stands on: the device and its features, shader modules, bind groups and
//! dispatches, and timestamps. Knows nothing of points.

pub mod device;
pub mod kernel;
pub mod shaders;
pub mod timing;
