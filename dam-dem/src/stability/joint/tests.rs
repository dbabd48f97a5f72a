use super::*;
use crate::uplift::Drains;

const GAMMA: f64 = 9810.0;

fn drains(position: f64, efficiency: f64) -> Uplift {
    Uplift { drains: Some(Drains { position, efficiency, gallery_elevation: None }), ..Uplift::default() }
}

fn horizontal(length: f64, elevation: f64, levels: [f64; 2]) -> JointWater {
    JointWater::new([[0.0, elevation], [length, elevation]], levels, [GAMMA; 2])
}

/// Joint without uplift of its own, of this length.
fn dry(length: f64) -> JointWater {
    horizontal(length, 0.0, [0.0; 2])
}

fn load(normal: f64, shear: f64, moment: f64) -> JointLoad {
    JointLoad { normal, shear, moment }
}

fn state(water: &JointWater, uplift: &Uplift, load: JointLoad, strength: Strength, mode: Mode) -> JointState {
    Joint { water, uplift, uplift_factor: 1.0, load, strength }.state(mode)
}

fn assert_near(found: f64, expected: f64, scale: f64, name: &str) {
    assert!((found - expected).abs() <= scale, "{name}: {found} instead of {expected}");
}

struct Case {
    name: &'static str,
    length: f64,
    elevation: f64,
    levels: [f64; 2],
    drains: Option<(f64, f64)>,
    mode: Mode,
    /// V, kN/m; M, kN; H, kN/m.
    load: [f64; 3],
    /// Coefficient of friction, and cohesion in kPa.
    strength: [f64; 2],
    /// Crack length, m.
    crack: f64,
    /// U and N', kN/m.
    uplift: f64,
    normal: f64,
    /// Distance of the resultant from the downstream end, m.
    resultant: f64,
    /// Effective stresses at the heel or the tip, and at the toe, kPa.
    stresses: [f64; 2],
    sliding_factor: f64,
}

const FULL: Mode = Mode::Seismic { rule: UpliftRule::FullWhereOpen, before: [0.0; 2] };
const FROZEN: Mode = Mode::Seismic { rule: UpliftRule::Unchanged, before: [0.0; 2] };

/// Computed independently of this project, twice: by iteration with exact integrals, and by closed forms or
/// bisection on sampled pressures. A: triangles 100 m high; B, D2: base of Koyna Dam; C, D1, E: its lift
/// joint at 66.5 m.
#[rustfmt::skip]
const CASES: [Case; 11] = [
    Case {
        name: "A1", length: 90.0, elevation: 0.0, levels: [100.0, 0.0], drains: None,
        mode: Mode::Static, load: [105948.0, 4721880.0, 49050.0], strength: [1.0, 0.0], crack: 0.0,
        uplift: 44145.0, normal: 61803.0, resultant: 33.54497354,
        stresses: [162.2888889, 1211.111111], sliding_factor: 1.26,
    },
    Case {
        name: "A3", length: 80.0, elevation: 0.0, levels: [100.0, 0.0], drains: Some((8.0, 0.67)),
        mode: Mode::Static, load: [94176.0, 3387720.0, 49050.0], strength: [1.0, 0.0], crack: 0.0,
        uplift: 15578.28, normal: 78597.72, resultant: 31.72840739, stresses: [372.9762, 1591.9668],
        sliding_factor: 1.6024,
    },
    Case {
        name: "A3b", length: 80.0, elevation: 0.0, levels: [100.0, 0.0], drains: Some((8.0, 0.5)),
        mode: Mode::Static, load: [94176.0, 3387720.0, 49050.0], strength: [1.0, 0.0], crack: 0.0,
        uplift: 21582.0, normal: 72594.0, resultant: 30.16216216, stresses: [237.8925, 1576.9575],
        sliding_factor: 1.48,
    },
    Case {
        name: "B1", length: 70.0, elevation: 0.0, levels: [91.75, 20.0], drains: None,
        mode: Mode::Static, load: [94446.02593, 3226874.279, 39328.59656], strength: [1.0, 0.0],
        crack: 0.0, uplift: 38369.3625, normal: 56076.66343, resultant: 28.47056032,
        stresses: [352.7492432, 1249.441141], sliding_factor: 1.425849594,
    },
    Case {
        name: "B2", length: 70.0, elevation: 0.0, levels: [91.75, 20.0], drains: Some((7.0, 0.67)),
        mode: Mode::Static, load: [94446.02593, 3226874.279, 39328.59656], strength: [1.0, 0.0],
        crack: 0.0, uplift: 23514.23891, normal: 70931.78702, resultant: 31.79267391,
        stresses: [734.7381354, 1291.884351], sliding_factor: 1.803567715,
    },
    Case {
        name: "C1", length: 19.25, elevation: 66.5, levels: [91.75, 0.0], drains: None,
        mode: Mode::Static, load: [16093.58949, 145703.9823, 3127.244063], strength: [1.0, 1000.0],
        crack: 0.0, uplift: 2384.136563, normal: 13709.45293, resultant: 8.396218554,
        stresses: [439.4169418, 984.9418039], sliding_factor: 10.53945655,
    },
    Case {
        name: "C3", length: 19.25, elevation: 66.5, levels: [91.75, 0.0], drains: Some((2.5, 0.5)),
        mode: Mode::Static, load: [16093.58949, 145703.9823, 3127.244063], strength: [0.7, 0.0],
        crack: 0.0, uplift: 1346.882344, normal: 14746.70715, resultant: 8.649701414,
        stresses: [533.1879422, 998.9374756], sliding_factor: 3.30089203,
    },
    Case {
        name: "D1", length: 19.25, elevation: 66.5, levels: [91.75, 0.0], drains: None, mode: FULL,
        load: [16093.58949, 75472.78854, 7736.910001], strength: [0.7, 0.0], crack: 11.41494478,
        uplift: 3797.891742, normal: 12295.69775, resultant: 2.611685074,
        stresses: [0.0, 3138.637163], sliding_factor: 1.112458129,
    },
    Case {
        name: "D2", length: 70.0, elevation: 0.0, levels: [91.75, 0.0], drains: None, mode: FROZEN,
        load: [92948.71014, 2687163.137, 55402.70384], strength: [1.0, 0.0], crack: 10.57972848,
        uplift: 31502.3625, normal: 61446.34764, resultant: 19.80675717,
        stresses: [0.0, 2068.194778], sliding_factor: 1.109085719,
    },
    Case {
        name: "E1", length: 19.25, elevation: 66.5, levels: [91.75, 0.0], drains: None,
        mode: Mode::Given([10.0, 0.0]), load: [16093.58949, 145703.9823, 3127.244063],
        strength: [0.700207538, 0.0], crack: 10.0, uplift: 3622.649063, normal: 12470.94043,
        resultant: 8.286599947, stresses: [377.5853176, 918.0968048], sliding_factor: 2.792313718,
    },
    Case {
        name: "E2", length: 19.25, elevation: 66.5, levels: [91.75, 0.0], drains: None,
        mode: Mode::Given([19.25, 0.0]), load: [16093.58949, 145703.9823, 3127.244063],
        strength: [0.700207538, 0.0], crack: 19.25, uplift: 4768.273125, normal: 11325.31637,
        resultant: 8.81294175, stresses: [439.4169418, 737.2393039], sliding_factor: 2.535802046,
    },
];

#[test]
fn reproduces_the_check_cases() {
    const TOLERANCE: f64 = 1e-7;
    for case in &CASES {
        let water = horizontal(case.length, case.elevation, case.levels);
        let uplift = case.drains.map_or_else(Uplift::default, |(at, efficiency)| drains(at, efficiency));
        let [normal, moment, shear] = case.load.map(|value| 1e3 * value);
        let strength =
            Strength { friction: case.strength[0], cohesion: 1e3 * case.strength[1], tensile_strength: 0.0 };
        let found = state(&water, &uplift, load(normal, shear, moment), strength, case.mode);
        let near = |found: f64, expected: f64, scale: f64, quantity: &str| {
            assert_near(found, expected, scale * TOLERANCE, &format!("{} {quantity}", case.name));
        };
        near(found.cracks[0], case.crack, case.length, "crack");
        near(found.uplift / 1e3, case.uplift, case.uplift, "U");
        near(found.normal / 1e3, case.normal, case.normal, "N'");
        near(found.resultant.unwrap(), case.resultant, case.length, "resultant");
        near(found.share().unwrap(), case.resultant / case.length, 1.0, "share");
        let stresses = found.stresses.unwrap();
        for (found, expected) in stresses.into_iter().zip(case.stresses) {
            near(found / 1e3, expected, case.stresses[1], "stress");
        }
        near(found.sliding_factor.unwrap(), case.sliding_factor, case.sliding_factor, "sliding");
        assert!(!found.overturns());
        assert_eq!(found.is_cracked_through(), case.name == "E2");
        assert_eq!(found.opens_from().is_some(), case.name.starts_with('D'), "{}", case.name);
    }
}

/// Case G1, a block of 20 m on a joint without uplift with thrust of 1962 kN/m: at the ground acceleration
/// (μ N' − T)/(m + m_a) the factor is 1.
#[test]
fn block_slides_at_its_critical_acceleration() {
    let [mass, added_mass, thrust] = [1920e3, 1e3 * 700.0 / 3.0, 1962e3];
    let weight = mass * 9.81;
    let strength = Strength { friction: 0.8, ..Strength::default() };
    let shear = thrust + (mass + added_mass) * 6.086452012;
    let found =
        state(&dry(20.0), &Uplift::default(), load(weight, shear, 10.0 * weight), strength, Mode::Static);
    assert_near(found.sliding_factor.unwrap(), 1.0, 1e-9, "sliding");
}

/// Triangle with a vertical face, full reservoir and full uplift:
/// σ_heel = γH(s − 1 − (H/B)²), σ_toe = γH(H/B)², FS = μ(s − 1)B/H.
#[test]
fn uncracked_triangle_has_its_closed_form() {
    let density_ratio = 2.4;
    for (height, base) in [(100.0, 90.0), (30.0, 26.0), (250.0, 212.0), (10.0, 40.0)] {
        let weight = density_ratio * GAMMA * height * base / 2.0;
        let thrust = GAMMA * height * height / 2.0;
        let load = load(weight, thrust, weight * base * 2.0 / 3.0 - thrust * height / 3.0);
        let strength = Strength { friction: 0.9, ..Strength::default() };
        let water = horizontal(base, 0.0, [height, 0.0]);
        let found = state(&water, &Uplift::default(), load, strength, Mode::Static);
        let slope = (height / base).powi(2);
        let expected = [density_ratio - 1.0 - slope, slope].map(|share| GAMMA * height * share);
        for (found, expected) in found.stresses.unwrap().into_iter().zip(expected) {
            assert_near(found, expected, 1e-12 * GAMMA * height, "stress");
        }
        let factor = 0.9 * (density_ratio - 1.0) * base / height;
        assert_near(found.sliding_factor.unwrap(), factor, 1e-12, "sliding");
        assert_eq!((found.cracks, found.compressed, found.bonded), ([0.0; 2], base, base));
    }
}

/// Cracked base with full pressure in the crack, which falls linearly from its tip to 0 at the toe:
/// c = 3(M − γH₁L²/2)/(V − γH₁L), from M' = N' c/3, in which the terms with c² cancel.
#[test]
fn cracked_base_has_its_closed_form() {
    for k in 0..20 {
        let height = 20.0 + 9.0 * f64::from(k);
        let base = height * (0.845 - 0.0045 * f64::from(k));
        let weight = 2.4 * GAMMA * height * base / 2.0;
        let thrust = GAMMA * height * height / 2.0;
        let moment = weight * base * 2.0 / 3.0 - thrust * height / 3.0;
        let pressure = GAMMA * height;
        let contact = 3.0 * (moment - pressure * base * base / 2.0) / (weight - pressure * base);
        assert!(contact > 0.05 * base && contact < base);
        let water = horizontal(base, 0.0, [height, 0.0]);
        let strength = Strength { friction: 1.0, cohesion: 1e5, tensile_strength: 0.0 };
        let found = state(&water, &Uplift::default(), load(weight, thrust, moment), strength, Mode::Static);
        assert_near(found.cracks[0], base - contact, 1e-10 * base, "crack");
        assert_near(found.compressed, contact, 1e-10 * base, "compressed");
        let normal = weight - pressure * (base - contact / 2.0);
        assert_near(found.sliding_factor.unwrap(), (normal + 1e5 * contact) / thrust, 1e-10, "sliding");
        assert_eq!(found.opens_from(), Some(End::Upstream));
    }
}

/// Joint of 20 m, 400 kPa at the heel before the earthquake, V = 8 MN/m at 8 m from the toe. With the contact
/// c, equilibrium is c³ + 800 c = 19200; the iteration of the guidelines alternates between 0 and 12 m.
#[test]
fn finds_the_root_where_the_plain_iteration_cycles() {
    let (length, normal, moment, heel) = (20.0, 8e6, 64e6, 400e3);
    let mut cracks = vec![0.0];
    for _ in 0..1000 {
        let contact: f64 = length - cracks[cracks.len() - 1];
        let [force, arm] = [heel * contact / length * contact / 2.0, contact * 2.0 / 3.0];
        let next: f64 = length - 3.0 * (moment - force * arm) / (normal - force);
        cracks.push(next.max(0.0));
    }
    assert!(cracks.iter().skip(1).step_by(2).all(|&crack| (crack - 12.0).abs() < 1e-12));
    assert!(cracks.iter().step_by(2).all(|&crack| crack == 0.0));

    let mode = Mode::Seismic { rule: UpliftRule::ZeroWhereOpen, before: [0.0; 2] };
    let water = horizontal(length, 0.0, [heel / GAMMA, 0.0]);
    let found = state(&water, &Uplift::default(), load(normal, 0.0, moment), Strength::default(), mode);
    let contact = length - found.cracks[0];
    assert_near((contact.powi(3) + 800.0 * contact) / 19200.0, 1.0, 1e-12, "equilibrium");
    assert_near(found.resultant.unwrap() / contact, 1.0 / 3.0, 1e-12, "resultant");
    let [tip, toe] = found.stresses.unwrap();
    assert!(tip.abs() < 1e-9 * toe);
    // no force along the joint
    assert_eq!(found.sliding_factor, None);
}

/// Pressure by the rules, written from the table for horizontal joints: heads in Pa, crack from upstream.
fn independent(heads: [f64; 2], length: f64, drains: Option<(f64, f64)>, crack: f64, x: f64) -> f64 {
    let line = |a: f64, pa: f64, b: f64, pb: f64| pa + (pb - pa) * (x - a) / (b - a);
    match drains {
        _ if x < crack => heads[0],
        Some((at, efficiency)) if crack < at => {
            let third = heads[1] + (1.0 - efficiency) * (heads[0] - heads[1]) * (length - at) / length;
            if x < at { line(crack, heads[0], at, third) } else { line(at, third, length, heads[1]) }
        }
        _ => line(crack, heads[0], length, heads[1]),
    }
}

struct Sums {
    normal: f64,
    moment: f64,
}

/// Midpoint sums of effective stress and uplift along the joint.
fn sums(length: f64, pressure: impl Fn(f64) -> f64, found: &JointState) -> Sums {
    let strips = 100_000;
    let [upstream, downstream] = found.stresses.unwrap();
    let [start, end] = [found.open[0], length - found.open[1]];
    let mut sums = Sums { normal: 0.0, moment: 0.0 };
    for k in 0..strips {
        let x = (k as f64 + 0.5) / strips as f64 * length;
        let contact = if (start..=end).contains(&x) {
            upstream + (downstream - upstream) * (x - start) / (end - start)
        } else {
            0.0
        };
        let total = (contact + pressure(x)) * length / strips as f64;
        sums.normal += total;
        sums.moment += total * (length - x);
    }
    sums
}

/// Numbers in [0, 1) from a multiplicative congruential generator.
fn random() -> impl FnMut() -> f64 {
    let mut seed = 20_260_101_u64;
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[test]
fn found_states_are_in_equilibrium_and_open_no_further_than_needed() {
    let mut random = random();
    let (mut opened, mut overturned) = (0, 0);
    for trial in 0..200 {
        let length = 10.0 + 90.0 * random();
        let high = length * (0.6 + 0.6 * random());
        let heads = [GAMMA * high, GAMMA * high * 0.3 * random()];
        let place = (trial % 2 == 0).then(|| (length * (0.05 + 0.3 * random()), random()));
        let uplift = place.map_or_else(Uplift::default, |(at, efficiency)| drains(at, efficiency));
        let before = if trial % 3 == 0 { 0.3 * length * random() } else { 0.0 };
        let normal = heads[0] * length * (1.1 + 0.6 * random());
        let loads = load(normal, 1.0, normal * length * (0.3 + 0.25 * random()));
        let strength = Strength {
            tensile_strength: if trial % 5 == 0 { 0.05 * heads[0] } else { 0.0 },
            ..Strength::default()
        };
        let water = horizontal(length, 0.0, heads.map(|head| head / GAMMA));
        let modes = UpliftRule::ALL.map(|rule| Mode::Seismic { rule, before: [before, 0.0] });
        for mode in modes.into_iter().chain([Mode::Static, Mode::Given([before, 0.0])]) {
            let cracked = if mode == Mode::Static { 0.0 } else { before };
            // by the rules, for an opening from upstream
            let pressure = |open: f64, x: f64| match mode.rule() {
                UpliftRule::ZeroWhereOpen if x < open => 0.0,
                UpliftRule::FullWhereOpen => independent(heads, length, place, cracked.max(open), x),
                _ => independent(heads, length, place, cracked, x),
            };
            let found = state(&water, &uplift, loads, strength, mode);
            // tip stress times c²/L, coarse sums
            let reserve = |open: f64| {
                let strips = 2000;
                let width = length / f64::from(strips);
                let [mut force, mut arms] = [normal, loads.moment];
                for k in 0..strips {
                    let x = (f64::from(k) + 0.5) * width;
                    force -= pressure(open, x) * width;
                    arms -= pressure(open, x) * width * (length - x);
                }
                let contact = length - open;
                let bond = if open < cracked { 0.0 } else { strength.tensile_strength };
                ((6.0 * arms - 2.0 * force * contact + bond * contact * contact) / length).min(force)
            };
            let admissible = if found.overturns() { length } else { found.open[0] };
            for k in 0..if admissible > 0.0 { 10 } else { 0 } {
                let open = admissible * f64::from(k) / 10.0;
                assert!(reserve(open) < 2e-3 * normal, "{trial} {mode:?} {open}");
            }
            if found.overturns() {
                overturned += 1;
                assert_eq!(found.open, [length, 0.0]);
                continue;
            }
            assert_eq!(found.open[1], 0.0);
            opened += usize::from(found.open[0] > 0.0);
            let sums = sums(length, |x| pressure(found.open[0], x), &found);
            assert_near(sums.normal, normal, 3e-5 * normal, "V");
            assert_near(sums.moment, loads.moment, 3e-5 * normal * length, "M");
            let [tip, toe] = found.stresses.unwrap();
            assert!(tip >= -strength.tensile_strength - 1e-9 * toe && toe > 0.0);
            if found.open[0] > 0.0 && found.open[0] != before {
                let limit = if found.open[0] < cracked { 0.0 } else { strength.tensile_strength };
                assert_near(tip, -limit, 1e-8 * toe, "tip");
            }
        }
    }
    assert!(opened > 200 && overturned > 50 && opened + overturned < 900, "{opened} {overturned}");
}

/// Mirrored loads and waters give the mirrored state.
#[test]
fn opening_from_downstream_mirrors_that_from_upstream() {
    let uplift = drains(6.0, 0.6);
    let mirrored_uplift = drains(54.0, 0.6);
    let water = horizontal(60.0, 0.0, [50.0, 10.0]);
    let mirrored_water = horizontal(60.0, 0.0, [10.0, 50.0]);
    let normal = 50e6;
    let strength = Strength { friction: 1.0, cohesion: 1e5, tensile_strength: 1e4 };
    let swap = |[a, b]: [f64; 2]| [b, a];
    let modes = UpliftRule::ALL.map(|rule| Mode::Seismic { rule, before: [4.0, 0.0] });
    for mode in modes.into_iter().chain([Mode::Static, Mode::Given([15.0, 2.0])]) {
        let mirrored_mode = match mode {
            Mode::Static => Mode::Static,
            Mode::Seismic { rule, before } => Mode::Seismic { rule, before: swap(before) },
            Mode::Given(cracks) => Mode::Given(swap(cracks)),
        };
        for distance in [18.0, 21.0, 24.0, 30.0] {
            let loads = load(normal, 10e6, normal * distance);
            let mirrored = load(normal, -10e6, normal * (60.0 - distance));
            let a = state(&water, &uplift, loads, strength, mode);
            let b = state(&mirrored_water, &mirrored_uplift, mirrored, strength, mirrored_mode);
            for end in [0, 1] {
                assert_near(b.open[1 - end], a.open[end], 1e-9, "open");
                assert_near(b.cracks[1 - end], a.cracks[end], 1e-9, "cracks");
            }
            assert_near(b.bonded, a.bonded, 1e-9, "bonded");
            assert_near(b.uplift, a.uplift, 1e-3, "uplift");
            assert_eq!(b.overturns(), a.overturns());
            if let (Some(a), Some(b)) = (a.stresses, b.stresses) {
                assert_near(b[0], a[1], 1e-2, "stress");
                assert_near(b[1], a[0], 1e-2, "stress");
            }
            assert_near(b.sliding_factor.unwrap(), a.sliding_factor.unwrap(), 1e-9, "sliding");
        }
    }
}

/// Without water, 1 MN/m at 8 m from the upstream end of 30 m presses 24 m: 83.3 kPa at the heel.
#[test]
fn empty_reservoir_opens_the_joint_from_the_toe() {
    let strength = Strength { friction: 0.5, cohesion: 1e4, tensile_strength: 0.0 };
    let found = state(&dry(30.0), &Uplift::default(), load(1e6, -1e5, 22e6), strength, Mode::Static);
    assert_eq!(found.opens_from(), Some(End::Downstream));
    assert_near(found.open[1], 6.0, 1e-9, "open");
    assert_near(found.compressed, 24.0, 1e-9, "compressed");
    let [heel, tip] = found.stresses.unwrap();
    assert_near(heel, 1e6 / 12.0, 1e-4, "heel");
    assert_near(tip, 0.0, 1e-4, "tip");
    // a force upstream counts as one downstream
    assert_near(found.sliding_factor.unwrap(), 7.4, 1e-9, "sliding");
    assert_eq!(found.zone(), ResultantZone::MiddleHalf);
}

/// Eccentricity b/4 on a dry joint of 12 m: σ = V/L (1 ∓ 6/4), tension of half the mean stress at the heel.
#[test]
fn tensile_strength_keeps_the_joint_closed() {
    let loads = load(1.2e6, 1e5, 1.2e6 * 3.0);
    let with = |tensile_strength| {
        let strength = Strength { friction: 1.0, cohesion: 1e5, tensile_strength };
        state(&dry(12.0), &Uplift::default(), loads, strength, Mode::Static)
    };
    let closed = with(50.1e3);
    assert_eq!((closed.cracks, closed.opens_from()), ([0.0; 2], None));
    let [heel, toe] = closed.stresses.unwrap();
    assert_near(heel, -50e3, 1e-6, "heel");
    assert_near(toe, 250e3, 1e-6, "toe");
    // cohesion on the part in compression: from 2 m on
    assert_near(closed.compressed, 10.0, 1e-9, "compressed");
    assert_near(closed.sliding_factor.unwrap(), (1.2e6 + 1e5 * 10.0) / 1e5, 1e-9, "sliding");
    // 6 M/c² − 2 V/c = −f_t: 40 c² − 2400 c + 21600 = 0 in kN and m
    let cracked = with(40e3);
    let contact = 30.0 - (900.0_f64 - 540.0).sqrt();
    assert_near(cracked.cracks[0], 12.0 - contact, 1e-9, "crack");
    assert_near(with(0.0).cracks[0], 3.0, 1e-9, "crack");
}

/// The joint of the test before with a crack of 4 m: its faces carry no tension, so that it opens by 3 m. A
/// crack of 1 m opens to its tip, where the bond holds.
#[test]
fn crack_before_the_earthquake_has_no_tensile_strength() {
    let loads = load(1.2e6, 1e5, 1.2e6 * 3.0);
    let strength = Strength { friction: 1.0, cohesion: 1e5, tensile_strength: 45e3 };
    for (before, open) in [(4.0, 3.0), (1.0, 1.0)] {
        let mode = Mode::Seismic { rule: UpliftRule::Unchanged, before: [before, 0.0] };
        let found = state(&dry(12.0), &Uplift::default(), loads, strength, mode);
        assert_near(found.open[0], open, 1e-9, "open");
        assert_eq!(found.cracks, [before, 0.0]);
        if before == 4.0 {
            assert_near(found.bonded, 8.0, 1e-9, "bonded");
            assert_near(found.compressed, 9.0, 1e-9, "compressed");
        } else {
            let [tip, _] = found.stresses.unwrap();
            // 6 · 3.6 MN/11² − 2 · 1.2 MN/11
            assert_near(tip, 1e6 * (21.6 / 121.0 - 2.4 / 11.0), 1e-6, "tip");
        }
    }
}

/// Opening from the toe, with a crack at the heel that is pressed together: 24 m in contact, 24 − 5 m bonded.
#[test]
fn closed_crack_at_the_other_end_carries_no_cohesion() {
    let strength = Strength { friction: 0.5, cohesion: 1e4, tensile_strength: 0.0 };
    let mode = Mode::Given([5.0, 0.0]);
    let found = state(&dry(30.0), &Uplift::default(), load(1e6, -1e5, 22e6), strength, mode);
    assert_near(found.cracks[0], 5.0, 0.0, "crack");
    assert_near(found.cracks[1], 6.0, 1e-9, "crack");
    assert_near(found.bonded, 19.0, 1e-9, "bonded");
    assert_near(found.sliding_factor.unwrap(), (0.5e6 + 19e4) / 1e5, 1e-9, "sliding");
}

/// A given crack with full pressure opens again where the whole joint would be in tension at the heel.
#[test]
fn given_crack_opens_where_the_whole_joint_would_be_in_tension() {
    let water = horizontal(20.0, 0.0, [20.0, 0.0]);
    let loads = load(8e6, 1.0, 8e6 * 7.5);
    let found = state(&water, &Uplift::default(), loads, Strength::default(), Mode::Given([12.0, 0.0]));
    assert_eq!(found.cracks, [12.0, 0.0]);
    assert!(found.open[0] > 0.0 && found.open[0] < 12.0);
    // U does not depend on the opening below 12 m
    let pressure = 20.0 * GAMMA;
    let normal = 8e6 - pressure * 16.0;
    let moment = 60e6 - pressure * (12.0 * 14.0 + 8.0 * 8.0 / 3.0);
    assert_near(found.open[0], 20.0 - 3.0 * moment / normal, 1e-9, "open");
}

/// The joint of the two tests of tensile strength, cracked through: it opens by 3 m in spite of its strength,
/// from either end.
#[test]
fn joint_cracked_through_has_no_tensile_strength() {
    let strength = Strength { tensile_strength: 1e9, ..Strength::default() };
    for (distance, open) in [(3.0, [3.0, 0.0]), (9.0, [0.0, 3.0])] {
        let loads = load(1.2e6, 1e5, 1.2e6 * distance);
        for cracks in [[12.0, 0.0], [0.0, 12.0], [7.0, 5.0]] {
            let found = state(&dry(12.0), &Uplift::default(), loads, strength, Mode::Given(cracks));
            assert_near(found.open[0], open[0], 1e-9, "open");
            assert_near(found.open[1], open[1], 1e-9, "open");
            assert!(found.is_cracked_through() && !found.overturns() && found.bonded == 0.0);
        }
    }
}

/// The joint whose plain iteration cycles, under 3.5 MN/m, less than the uplift of 4 MN/m before it opens:
/// with a contact of 12 m, M = V c/3 + c³/300 MN.
#[test]
fn opening_can_relieve_an_uplift_larger_than_the_load() {
    let water = horizontal(20.0, 0.0, [400e3 / GAMMA, 0.0]);
    let mode = Mode::Seismic { rule: UpliftRule::ZeroWhereOpen, before: [0.0; 2] };
    let loads = load(3.5e6, 1.0, 3.5e6 * 4.0 + 12.0_f64.powi(3) / 300.0 * 1e6);
    let found = state(&water, &Uplift::default(), loads, Strength::default(), mode);
    assert_near(found.open[0], 8.0, 1e-9, "open");
    assert_near(found.normal, 3.5e6 - 1.44e6, 1e-3, "normal");
}

#[test]
fn joint_without_equilibrium_overturns() {
    let strength = Strength { friction: 0.8, cohesion: 1e6, tensile_strength: 0.0 };
    let water = horizontal(20.0, 0.0, [20.0, 4.0]);
    // resultant beyond the toe; full pressure of the reservoir over the whole joint
    let found = state(&water, &Uplift::default(), load(8e6, 1e6, -8e6), strength, Mode::Static);
    assert!(found.overturns() && found.is_cracked_through());
    assert_eq!((found.cracks, found.open), ([20.0, 0.0], [20.0, 0.0]));
    assert_near(found.uplift, 20.0 * GAMMA * 20.0, 1e-6, "uplift");
    assert_eq!((found.compressed, found.bonded, found.stresses), (0.0, 0.0, None));
    assert_near(found.sliding_factor.unwrap(), 0.8 * (8.0 - 3.924), 1e-9, "sliding");
    assert_eq!(found.zone(), ResultantZone::Outside);
    // beyond the heel; pressure of the tailwater
    let found = state(&water, &Uplift::default(), load(8e6, -1e6, 168e6), strength, Mode::Static);
    assert!(found.overturns());
    assert_eq!((found.opens_from(), found.cracks), (Some(End::Downstream), [0.0, 20.0]));
    assert_near(found.uplift, 4.0 * GAMMA * 20.0, 1e-6, "uplift");
    // uplift larger than the weight: no resistance
    let found = state(&water, &Uplift::default(), load(1e6, 1e6, 10e6), strength, Mode::Static);
    assert!(found.overturns() && found.normal < 0.0);
    assert_eq!((found.resultant, found.zone()), (None, ResultantZone::Outside));
    assert_eq!(found.sliding_factor, Some(0.0));
    // tensile strength does not carry a tensile resultant
    let bonded = Strength { tensile_strength: 1e9, ..strength };
    assert!(state(&water, &Uplift::default(), load(1e6, 1e6, 10e6), bonded, Mode::Static).overturns());
    // no load at all, and one that is not a number
    for normal in [0.0, f64::NAN] {
        let loads = load(normal, 1.0, normal);
        assert!(state(&dry(20.0), &Uplift::default(), loads, strength, Mode::Static).overturns());
    }
}

/// The crack reaches the drains and puts them out of service: with E = 1 at 4 m of 20 m, the state with
/// working drains would be in equilibrium at an opening of 4 m or less only for a smaller moment.
#[test]
fn crack_that_reaches_the_drains_grows_at_once() {
    let water = horizontal(20.0, 0.0, [20.0, 0.0]);
    let pressure = 20.0 * GAMMA;
    let cracked = |distance: f64| {
        let loads = load(6e6, 1.0, 6e6 * distance);
        state(&water, &drains(4.0, 1.0), loads, Strength::default(), Mode::Static).cracks[0]
    };
    // equilibrium with a tip at the drains, still working: M' = N' c/3
    let at_drains = (pressure * 4.0 * 18.0 + (6e6 - pressure * 4.0) * 16.0 / 3.0) / 6e6;
    assert_near(cracked(at_drains + 1e-9), 4.0, 1e-5, "before");
    let moment = 6e6 * (at_drains - 1e-9);
    let contact = 3.0 * (moment - pressure * 200.0) / (6e6 - pressure * 20.0);
    assert!(contact < 15.0);
    assert_near(cracked(at_drains - 1e-9), 20.0 - contact, 1e-6, "after");
}

/// A joint that rises by 8 m over 15 m below a reservoir at 14 m.
#[test]
fn sloping_joint_has_its_pressure_from_the_total_head() {
    let water = JointWater::new([[0.0, 2.0], [15.0, 10.0]], [14.0, 0.0], [GAMMA; 2]);
    let loads = load(5e6, 1e6, 5e6 * 8.0);
    let found = state(&water, &Uplift::default(), loads, Strength::default(), Mode::Static);
    // 12 m of head at the heel, none at the toe, 17 m long
    let [uplift, arm] = [12.0 * GAMMA * 8.5, 17.0 * 2.0 / 3.0];
    assert_near(found.uplift, uplift, 1e-6, "uplift");
    assert_near(found.resultant.unwrap(), (40e6 - uplift * arm) / (5e6 - uplift), 1e-9, "resultant");
    // cracked through: 12 m at the heel, 4 m at the toe
    let through = state(&water, &Uplift::default(), loads, Strength::default(), Mode::Given([17.0, 0.0]));
    assert_near(through.uplift, 8.0 * GAMMA * 17.0, 1e-6, "uplift");
}

#[test]
fn factor_scales_the_whole_uplift() {
    let water = horizontal(20.0, 0.0, [20.0, 0.0]);
    let joint = |uplift_factor| {
        let load = load(8e6, 1.0, 8e6 * 11.0);
        let strength = Strength { friction: 1.0, ..Strength::default() };
        Joint { water: &water, uplift: &Uplift::default(), uplift_factor, load, strength }
            .state(Mode::Given([5.0, 0.0]))
    };
    assert_near(joint(0.25).uplift, 0.25 * joint(1.0).uplift, 1e-6, "uplift");
    assert_eq!(joint(0.0).uplift, 0.0);
}

#[test]
fn residual_strength_is_applied_to_the_same_state() {
    let water = horizontal(20.0, 0.0, [10.0, 0.0]);
    let peak = Strength { friction: 1.0, cohesion: 1e5, tensile_strength: 0.0 };
    let found = state(&water, &Uplift::default(), load(8e6, 2e6, 80e6), peak, Mode::Static);
    assert_eq!(found.sliding_factor, found.sliding_factor_with(1.0, 1e5));
    assert_near(found.sliding_factor_with(0.6, 0.0).unwrap(), 0.6 * found.normal / 2e6, 1e-12, "residual");
}

#[test]
fn zones_of_the_resultant_are_symmetric_and_closed() {
    use ResultantZone::{Inside, MiddleHalf, MiddleThird, Outside};
    let zones = [
        (0.5, MiddleThird),
        (1.0 / 3.0, MiddleThird),
        (0.33, MiddleHalf),
        (0.25, MiddleHalf),
        (0.24, Inside),
        (0.0, Inside),
        (-0.01, Outside),
        (f64::NAN, Outside),
    ];
    for (share, zone) in zones {
        assert_eq!((resultant_zone(share), resultant_zone(1.0 - share)), (zone, zone), "{share}");
    }
    assert!(MiddleThird < Outside);
    for zone in ResultantZone::ALL {
        assert!(!zone.word().is_empty() && !zone.label().is_empty());
    }
}
