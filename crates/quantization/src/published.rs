//! Transforms that were published, and the best ones found here: each once, with its source.

use crate::error::QuantizationError;
use crate::interval::DepthInterval;
use crate::optimum::{gain_bits, transform_range};
use crate::storage::AffineTransform;
use moment_problem::Basis;

/// A transform of power moments from a named source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Published {
    /// Name in experiments and tables.
    pub name: &'static str,
    /// Where it stands.
    pub source: &'static str,
    /// Number m of power moments z, ..., z^m.
    pub order: usize,
    /// Depths from -1 to 1, else from 0 to 1.
    pub signed: bool,
    /// Row-major.
    pub matrix: &'static [f64],
    /// What is added.
    pub offset: &'static [f64],
}

impl Published {
    /// The transform.
    ///
    /// # Errors
    /// None for the constants of this module, which a test builds.
    pub fn transform(&self) -> Result<AffineTransform, QuantizationError> {
        AffineTransform::new(self.matrix.to_vec(), self.offset.to_vec())
    }

    /// Its depths.
    pub fn interval(&self) -> DepthInterval {
        if self.signed { DepthInterval::SIGNED } else { DepthInterval::UNIT }
    }

    /// Bits gained, in the units of depths in \[0, 1\].
    ///
    /// # Errors
    /// As [`Published::transform`].
    pub fn gain_bits(&self) -> Result<f64, QuantizationError> {
        let log2 = self.transform()?.log2_determinant();
        Ok(gain_bits(&Basis::power(self.order), self.interval(), log2))
    }

    /// Least and largest stored value over all depths, proved. Outside \[0, 1\] only by the digits that were printed.
    ///
    /// # Errors
    /// As [`Published::transform`].
    pub fn range(&self) -> Result<(f64, f64), QuantizationError> {
        Ok(transform_range(&Basis::power(self.order), self.interval(), &self.transform()?))
    }

    /// The transform of a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        ALL.iter().find(|published| published.name == name)
    }
}

/// Square root of 3, which GDC16 writes as a formula.
const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// All of them.
pub const ALL: [Published; 8] = [
    Published {
        name: "MSM15 theta_2",
        source: "Peters and Klein, Moment Shadow Mapping, 2015, section 4.3",
        order: 2,
        signed: false,
        matrix: &[1.0, 0.0, 4.0, -4.0],
        offset: &[0.0, 0.0],
    },
    Published {
        name: "MSM15 theta_4",
        source: "Peters and Klein, Moment Shadow Mapping, 2015, section 4.3",
        order: 4,
        signed: false,
        #[rustfmt::skip]
        matrix: &[
            -2.07224649, 32.2370378, -68.5710746, 39.3703274,
            13.7948857, -59.4683976, 82.035975, -35.3649032,
            0.105877704, -1.90774663, 9.34965551, -6.65434907,
            9.79240621, -33.76521106, 47.9456097, -23.9728048,
        ],
        offset: &[0.0359558848, 0.0, 0.0, 0.0],
    },
    Published {
        name: "GDC16 four moments",
        source: "Peters, Moment Shadow Mapping and beyond, GDC Europe 2016, `Compute moments in resolve`",
        order: 4,
        signed: true,
        #[rustfmt::skip]
        matrix: &[
            1.5, 0.0, -2.0, 0.0,
            0.0, 4.0, 0.0, -4.0,
            SQRT_3 / 2.0, 0.0, -2.0 * SQRT_3 / 9.0, 0.0,
            0.0, 0.5, 0.0, 0.5,
        ],
        offset: &[0.5, 0.0, 0.5, 0.0],
    },
    Published {
        name: "GDC16 six moments",
        source: "Peters, Moment Shadow Mapping and beyond, GDC Europe 2016, `Quantization` of six moments",
        order: 6,
        signed: true,
        #[rustfmt::skip]
        matrix: &[
            2.5, 0.0, -10.0, 0.0, 8.0, 0.0,
            -1.87499864, 0.0, 4.20757543, 0.0, -1.83257679, 0.0,
            1.26583039, 0.0, -1.47644883, 0.0, 0.71061660, 0.0,
            0.0, 4.0, 0.0, -4.0, 0.0, 0.0,
            0.0, 9.0, 0.0, -24.0, 0.0, 16.0,
            0.0, -0.57759806, 0.0, 4.61936648, 0.0, -3.07953907,
        ],
        offset: &[0.5, 0.5, 0.5, 0.0, 0.0, 0.018888946],
    },
    Published {
        name: "ours, order 3",
        source: "found by this crate: `msm quantize --order 3 --depth-range signed`",
        order: 3,
        signed: true,
        #[rustfmt::skip]
        matrix: &[
            0.0, -0.9999999999999997, 0.0,
            0.8660254037844377, 0.0, -0.3849001794597501,
            -1.4999999999999565, 0.0, 1.999999999999942,
        ],
        offset: &[1.0, 0.5, 0.5],
    },
    Published {
        name: "ours, order 5",
        source: "found by this crate: `msm quantize --order 5 --depth-range signed`",
        order: 5,
        signed: true,
        #[rustfmt::skip]
        matrix: &[
            -0.9469078960455705, -2.7468466078509186, 1.692387199002635, 2.3393683928196345, -0.2621454872738644,
            -0.946908633738502, 2.746845728205526, 1.6923889950135154, -2.339367611969896, -0.2621465147256762,
            -4.7812232087443234e-8, 0.510820308038479, 3.223064808634579e-7, -1.4663321989856406, -2.744942476835219e-7,
            1.293385521461202, 1.8944761264577356e-7, -1.567799545054975, -1.3334953359206773e-7, 0.774414023593754,
            2.4999999999999254, 0.0, -9.9999999999997, 0.0, 7.999999999999759,
        ],
        offset: &[0.9241443993480654, 0.07585573031373316, 0.9555118909471682, 0.4999999439019211, 0.5],
    },
    Published {
        name: "ours, order 6",
        source: "found by this crate: `msm quantize --order 6 --depth-range signed`",
        order: 6,
        signed: true,
        #[rustfmt::skip]
        matrix: &[
            -2.1368958713514057, 8.416436733381401e-8, 6.244965649957552, -1.6392259215718748e-7, -3.6501166474233337, 8.979286861175777e-8,
            0.6689850818349703, -2.38368534487265, 0.7932212905074117, 4.529364822943917, -1.4622063723423828, -3.0934316609306642,
            1.0958629860698716, -7.281519310188269, -5.13557142429669, 17.386903633385508, 4.539706551348299, -10.565672561479897,
            1.0958630225467534, 7.281519229012915, -5.135571570941491, -17.386903383529788, 4.539706661575207, 10.565672389772319,
            0.0, -0.06896737332943516, 0.0, 6.921469673759698, 0.0, -6.852674959745933,
            -0.668985127137568, -2.383685368615566, -0.7932211641497946, 4.529364924015793, 1.462206291287363, -3.0934317316877644,
        ],
        offset: &[
            0.49999999159941066,
            0.9477521828594107,
            0.9602863514041597,
            0.03971365156406892,
            0.00017265931568216653,
            0.94775217628755,
        ],
    },
    Published {
        name: "ours, order 8",
        source: "found by this crate: `msm quantize --order 8 --depth-range signed`",
        order: 8,
        signed: true,
        #[rustfmt::skip]
        matrix: &[
            -0.3246717741671827, -11.210645477416657, 2.6739978655748047, 39.46663125040835, -6.276399065809903, -44.64138233408288, 4.427072974402272, 15.887740919524932,
            -0.4192188867611061, 0.03643999628754135, 10.33861978754986, -12.112812303785859, -27.639009360862538, 24.81229262729517, 18.219608460073776, -13.20440792624906,
            1.5009425656992421, 2.3417792548053202, -2.790014704432705, -6.520347651944789, 2.845032257207876, 7.29721182285462, -1.0583989632343433, -2.8401936385610815,
            0.34593261864507086, 0.7646079857083686, -8.57457974284037, -17.1545666328751, 22.30260332008361, 34.96158616683113, -14.073956195888307, -19.53648567001299,
            -2.4069784774004392, 9.342258625328952, 17.73106865568231, -42.86604809636802, -30.828935607279888, 69.28907123276326, 15.504845428998019, -35.900104212812714,
            -2.830315036459497, -2.737709034720362, 15.381900199699846, 24.762823372658204, -26.63397755690743, -49.486477509073524, 14.558474207081181, 27.40069599621015,
            2.3583983144522525, -4.9584589432423245, -9.298471345996253, 27.468794480326746, 11.224444655582326, -43.57753671519106, -4.279331720518701, 20.317804922503186,
            1.604335081808182, 10.76633962689007, -10.678341015246348, -44.788884378683214, 14.925081630256239, 65.56815264304083, -5.400863557641681, -31.15237434882587,
        ],
        offset: &[
            0.9976556415662589,
            0.9684876064522054,
            0.2191113680860058,
            0.9648581503486109,
            0.1348224510885327,
            0.5845853615114129,
            0.7549532765893303,
            0.056978596754579,
        ],
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Gains as the papers state them, recomputed with the digits that they print; ranges as the digits leave them.
    #[test]
    fn gains_and_ranges_of_the_printed_matrices() {
        for (name, gain, overshoot) in [
            ("MSM15 theta_2", 2.0, 1e-13),
            ("MSM15 theta_4", 12.27833, 1e-7),
            ("GDC16 four moments", 12.20752, 1e-13),
            ("GDC16 six moments", 30.51173, 1e-8),
            ("ours, order 3", 6.20752, 1e-12),
            ("ours, order 5", 20.37568, 1e-12),
            ("ours, order 6", 30.58714, 1e-12),
            ("ours, order 8", 56.81461, 1e-12),
        ] {
            let published = Published::named(name).unwrap();
            assert!(
                (published.gain_bits().unwrap() - gain).abs() < 6e-6,
                "{name}: {:?}",
                published.gain_bits()
            );
            let (min, max) = published.range().unwrap();
            assert!(min >= -overshoot && max <= 1.0 + overshoot, "{name}: {min:e} {:e}", max - 1.0);
            assert!(min < 1e-3 && max > 0.999, "{name}: {min} {max}");
        }
        // Whoever stores it must clamp.
        let (min, max) = Published::named("MSM15 theta_4").unwrap().range().unwrap();
        assert!((min + 7e-8).abs() < 1e-8 && (max - 1.0 - 2e-8).abs() < 1e-8, "{min:e} {:e}", max - 1.0);
        assert!(Published::named("theta_5").is_none());
    }

    #[test]
    fn the_inverse_of_the_talk_is_the_inverse_of_its_matrix() {
        let inverse = Published::named("GDC16 four moments").unwrap().transform().unwrap();
        #[rustfmt::skip]
        let printed = [
            -1.0 / 3.0, 0.0, SQRT_3, 0.0,
            0.0, 0.125, 0.0, 1.0,
            -0.75, 0.0, 0.75 * SQRT_3, 0.0,
            0.0, -0.125, 0.0, 1.0,
        ];
        for (ours, printed) in inverse.inverse().iter().zip(printed) {
            assert!((ours - printed).abs() < 1e-14, "{ours} {printed}");
        }
    }
}
