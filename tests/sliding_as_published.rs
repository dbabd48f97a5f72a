//! What is published of dams that slide, as signs and ratios: docs/measurements/validation.md, "What an engineer asks".

use cofferdam_dam::analytical::newmark_1965::slip_on_ground;
use whole_chain::scenario::{Histories, Scenario};

fn last(histories: &Histories, name: &str) -> f64 {
    histories.column(name).last().copied().expect("a row")
}

/// All of the Koyna dam and the water's added mass 7/12 ρh², held by the friction μW, pushed by the thrust ½ρgh²: its slip (m) on the ground of
/// a run. A thrust P is a ground that accelerates by −P/m.
fn newmark_block(histories: &Histories, friction: f64) -> f64 {
    let (gravity, density, depth) = (9.81, 1000.0, 91.75);
    // Half the sum of x Δy − y Δx around the section.
    let section = [[0.0, 0.0], [70.0, 0.0], [19.25, 66.5], [14.8, 103.0], [0.0, 103.0]];
    let sides = section.iter().zip(section.iter().cycle().skip(1));
    let area: f64 = sides.map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum();
    let dam = 2640.0 * area;
    let mass = dam + 7.0 / 12.0 * density * depth * depth;
    let thrust = 0.5 * density * gravity * depth * depth;
    let ground = histories.column("time").iter().zip(histories.column("ground_acceleration.x"));
    let samples: Vec<(f64, f64)> = ground.map(|(time, a)| (*time, a - thrust / mass)).collect();
    slip_on_ground(&samples, friction * dam * gravity / mass)
}

/// The rigid dam on its elastic joint slides a few per cent more than Newmark's block, the deformable one several times as far.
#[test]
fn a_base_joint_beside_newmarks_block() {
    let mut scenario = Scenario::shipped("koyna-base-joint");
    scenario.set("reservoir.fidelity", "westergaard").set("dam.cracks.0.friction_coefficient", 0.6);
    scenario.set("ground_motion.record.scale", 0.5);
    for polarity in [1, -1] {
        scenario.set("ground_motion.record.polarity", polarity);
        let mut slip = |fidelity: &str| {
            let histories = scenario.set("dam.fidelity", fidelity).run();
            std::fs::remove_dir_all(scenario.folder().join("run")).expect("the run's folder");
            (last(&histories, "dam.crack_sliding.0"), newmark_block(&histories, 0.6))
        };
        let (rigid, block) = slip("rigid-blocks");
        println!("polarity {polarity}: block {:.1} mm, rigid {:.1} mm", 1e3 * block, 1e3 * rigid);
        assert!(block > 0.01 && (1.0..1.05).contains(&(rigid / block)), "{rigid} m, {block} m");
        if polarity == 1 {
            let (deformable, _) = slip("reduced");
            println!("reduced {:.1} mm", 1e3 * deformable);
            assert!(deformable > 2.0 * block, "{deformable} m, {block} m");
        }
    }
}

/// Zhu and Pekau: with a second crack, at 30 m, the neck slides less.
#[test]
fn a_second_crack_spares_the_first() {
    let neck = |case: &str, crack: &str| {
        last(
            &Scenario::shipped(case).set("dam.fidelity", "reduced").run(),
            &format!("dam.crack_sliding.{crack}"),
        )
    };
    let (alone, beside) = (neck("koyna-coarse", "0"), neck("koyna-two-cracks", "1"));
    println!("neck: {:.0} mm alone, {:.0} mm beside a second crack", 1e3 * alone, 1e3 * beside);
    assert!(beside > 0.0 && beside < 0.9 * alone, "{alone} m, {beside} m");
}
