//! Equality of stacks, bit for bit.

use shadow_renderer::ShadowMapStack;

/// The first difference of two stacks; floats are compared by their bits.
pub fn compare(a: &ShadowMapStack, b: &ShadowMapStack) -> Result<(), String> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(format!("{}x{} is not {}x{}", a.width, a.height, b.width, b.height));
    }
    first_difference("offsets", a.offsets.iter().copied(), b.offsets.iter().copied())?;
    first_difference("depths", a.depths.iter().map(|d| d.to_bits()), b.depths.iter().map(|d| d.to_bits()))?;
    let bits = |s: &ShadowMapStack| s.gradients.iter().map(|g| g.map(f32::to_bits)).collect::<Vec<_>>();
    first_difference("gradients", bits(a).into_iter(), bits(b).into_iter())?;
    first_difference("light_facing", a.light_facing.iter(), b.light_facing.iter())?;
    let bits = |s: &ShadowMapStack| s.opacities.iter().map(|o| o.to_bits()).collect::<Vec<_>>();
    first_difference("opacities", bits(a).into_iter(), bits(b).into_iter())
}

fn first_difference<T: PartialEq + std::fmt::Debug>(
    name: &str,
    a: impl ExactSizeIterator<Item = T>,
    b: impl ExactSizeIterator<Item = T>,
) -> Result<(), String> {
    if a.len() != b.len() {
        return Err(format!("{name}: {} values are not {}", a.len(), b.len()));
    }
    match a.zip(b).enumerate().find(|(_, (a, b))| a != b) {
        Some((i, (a, b))) => Err(format!("{name}[{i}]: {a:?} is not {b:?}")),
        None => Ok(()),
    }
}

/// A comparison that cannot fail proves nothing: plants one fault in every array and expects each to be found.
pub fn finds_planted_faults(stack: &ShadowMapStack) -> Result<(), String> {
    compare(stack, &stack.clone())?;
    let middle = stack.fragments() / 2;
    let mut faults = Vec::new();
    let mut plant = |name, fault: &dyn Fn(&mut ShadowMapStack)| {
        let mut faulty = stack.clone();
        fault(&mut faulty);
        faults.push((name, faulty));
    };
    plant("depth, lowest bit", &|s| s.depths[middle] = f32::from_bits(s.depths[middle].to_bits() ^ 1));
    plant("gradient, lowest bit", &|s| {
        s.gradients[middle][1] = f32::from_bits(s.gradients[middle][1].to_bits() ^ 1)
    });
    plant("facing", &|s| {
        s.light_facing = s.light_facing.iter().enumerate().map(|(i, b)| b ^ (i == middle)).collect()
    });
    plant("opacity", &|s| s.opacities = vec![0.5; s.fragments()]);
    let texel = stack.offsets.len() / 2;
    plant("offset", &|s| s.offsets[texel] += 1);
    plant("missing fragment", &|s| {
        s.depths.pop();
    });
    plant("width", &|s| s.width += 1);
    match faults.iter().find(|(_, faulty)| compare(stack, faulty).is_ok()) {
        Some((name, _)) => Err(format!("the comparison missed a planted fault: {name}")),
        None => Ok(()),
    }
}
