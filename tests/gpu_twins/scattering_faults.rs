//! Faults planted in the compute passes of single scattering, which their comparison with Rust must see.

use super::adapter::gpu_trial;
use super::scattering::{march, prefiltered, resample, resample_filtered, techniques};
use applications::scattering::{Blending, Spacing};
use libtest_mimic::{Failed, Trial};

pub fn trials() -> Vec<Trial> {
    vec![gpu_trial("scattering::planted_faults".into(), planted_faults)]
}

/// Sums that are not normalised, a row too far, the other end of the blend, bounds without their guard band, and more.
fn planted_faults() -> Result<(), Failed> {
    let (_, spec, _) = techniques().swap_remove(2);
    for (fault, blending) in [
        (" / running[CHANNELS]=> / 1.0", Blending::Fixed(0.5)),
        ("azimuth(ray.x, ray.y)) - 0.5=>azimuth(ray.x, ray.y)) + 0.5", Blending::Fixed(0.5)),
        ("pair.x + beta * (pair.y - pair.x)=>pair.y + beta * (pair.x - pair.y)", Blending::Fixed(0.25)),
        ("0.5 + 0.5 * cosine=>0.5 - 0.5 * cosine", Blending::Adaptive),
        ("no guard band", Blending::Fixed(0.5)),
        ("view.column_width - 1.0=>view.column_width", Blending::Fixed(0.5)),
        ("running = totals[thread - 1u]=>running = totals[thread]", Blending::Fixed(0.5)),
        ("exponential(-exponent)=>1.0", Blending::Fixed(0.5)),
    ] {
        if prefiltered(&spec, (blending, Spacing::default()), &[fault]).is_ok() {
            return Err(format!("the comparison missed `{fault}`").into());
        }
    }
    let (_, of_sines, blending) = techniques().swap_remove(7);
    let (_, four, half) = techniques().swap_remove(1);
    for (spec, settings, fault) in [
        (&of_sines, (blending, Spacing::default()), "return MARGIN + STORED_SPAN * depth=>return depth"),
        (
            &four,
            (half, Spacing::Two),
            "(1.0 / sine - near) / (far - near)=>(1.0 / sine - far) / (near - far)",
        ),
        (&four, (half, Spacing::Two), "let row = map * ROWS + =>let row = "),
    ] {
        if prefiltered(spec, settings, &[fault]).is_ok() {
            return Err(format!("the comparison missed `{fault}`").into());
        }
    }
    for fault in [
        "stored < 1.0=>stored < 0.9",
        "(upper_angle(r, -z)=>(upper_angle(r, z)",
        "f32(index % COLUMNS) + 0.5=>f32(index % COLUMNS)",
    ] {
        if resample(fault).is_ok() {
            return Err(format!("resampling: the comparison missed `{fault}`").into());
        }
    }
    for fault in [
        "- 2.0 * b[0] * variance=>",
        "first + size.x * size.y=>first + size.x",
        "let base = floor(place)=>let base = floor(place + 0.5)",
        "clamp_unit(-roots.x=>clamp_unit(roots.y",
        "view.scale.x, view.scale.y)=>view.scale.x, view.scale.y) * 2.0",
    ] {
        if resample_filtered(fault).is_ok() {
            return Err(format!("filtered resampling: the comparison missed `{fault}`").into());
        }
    }
    for fault in
        ["weight = weight * decay=>weight = weight", "t * ray.z <= view.near=>t * ray.z <= view.near + 0.5"]
    {
        if march(fault).is_ok() {
            return Err(format!("marching: the comparison missed `{fault}`").into());
        }
    }
    Ok(())
}
