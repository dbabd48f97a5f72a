use cofferdam_coupling::participant::{Channel, ChannelShape, Layout};
use cofferdam_unit::{Variable, variables};

/// The output `name` of a dam or of a water, by the contract.
pub(super) fn known_output(name: &str) -> Option<&'static Variable> {
    let mut known = variables::dam::ALL.iter().chain(variables::reservoir::ALL);
    known.find(|v| v.name == name && v.causality == cofferdam_unit::Causality::Output)
}

/// The layout of an answer with the shapes that the contract gives its variables; a log only tells arrays from scalars.
pub fn shaped_outputs(layout: &Layout) -> Layout {
    let shaped = |channel: &Channel| {
        let shape = known_output(&channel.name).map(|v| ChannelShape::from(v.shape));
        let fits = |shape: &ChannelShape| {
            shape.is_array() == channel.shape.is_array()
                && (*shape != ChannelShape::Plane || channel.size == 2)
        };
        Channel { shape: shape.filter(fits).unwrap_or(channel.shape), ..channel.clone() }
    };
    Layout::new(layout.channels().map(|(channel, _)| shaped(channel)).collect())
}
