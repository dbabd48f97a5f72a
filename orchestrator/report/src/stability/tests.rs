use super::*;
use cofferdam_assembly::read_scene;

/// Histories of a crack: time, shear in use, open share, sliding.
fn histories(rows: &[[f64; 4]]) -> Histories {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("histories.csv");
    let names = ["crack_shear_utilisation", "crack_open_share", "crack_sliding"];
    let names = names.map(|name| format!("dam.{name}.0 [1]"));
    let rows = rows.iter().map(|row| row.map(|value| value.to_string()).join(","));
    let lines: Vec<String> = std::iter::once(format!("time [s],{}", names.join(","))).chain(rows).collect();
    std::fs::write(&path, lines.join("\n") + "\n").expect("a table");
    Histories::read(&path).expect("histories")
}

#[test]
fn each_shock_has_what_happened_in_it_and_the_length_opened_until_then() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/koyna-coarse");
    let record = "file='../records/northridge-1994-canyon-country-270.csv', start=4, end=5";
    let shocks = format!("ground_motion.sequence=[{{{record}, rest=2}}, {{{record}, rest=3, name='last'}}]");
    let crop = ["ground_motion.record.start=4", "ground_motion.record.end=5"].map(str::to_owned);
    let read = |sets: &[String]| read_scene(scene.as_ref(), sets).expect("a scene");
    let loaded = read(&[&crop[..], &[shocks]].concat());
    // they begin at 3.01 and 7.03 s
    let begins = loaded.ground_motion.begins();
    assert!((begins[1] - 3.01).abs() < 1e-9 && (begins[2] - 7.03).abs() < 1e-9, "{begins:?}");
    let table = [
        [0.0, 0.2, 0.0, 0.0],
        [1.0, 1.0, 0.3, 0.01],
        [1.5, 1.0, 0.2, 0.02],
        [3.01, 0.4, 0.1, 0.02],
        [4.0, 0.5, 0.2, 0.015],
        [7.03, 0.25, 0.1, 0.015],
        [7.5, 1.0, 0.6, 0.04],
        [9.0, 0.1, 0.0, 0.05],
    ];
    let (joints, shaken) = of_run(&loaded, &histories(&table), &[]).expect("joints");
    let length = joints[0].length;
    let wanted = [
        // least factor and its time, time at factor 1, open share so far, slid, in total
        ([1.0, 1.5, 1.5, 0.3, 0.02, 0.02], [0.0, 3.01]),
        ([2.0, 4.0, 0.0, 0.3, -0.005, 0.015], [3.01, 7.03]),
        ([1.0, 7.5, 0.47, 0.6, 0.035, 0.05], [7.03, 9.0]),
    ];
    assert_eq!(shaken.len(), wanted.len());
    let names = ["shock 1", "shock 2", "last"];
    for ((shock, (values, times)), name) in shaken.iter().zip(wanted).zip(names) {
        let Shaken { shock, least_factor, time, sliding_time, opened, slid, residual, .. } = &shock[0];
        let (label, found) = shock.as_ref().expect("one of several");
        assert_eq!(label, name);
        let found = [found[0] - times[0], found[1] - times[1]].into_iter().chain(
            [least_factor.expect("shear"), *time, *sliding_time, opened / length, *slid, *residual]
                .into_iter()
                .zip(values)
                .map(|(found, wanted)| found - wanted),
        );
        assert!(found.clone().all(|off| off.abs() < 1e-9), "{name}: {:?}", found.collect::<Vec<_>>());
    }
    let after: Vec<_> = joints.iter().filter(|joint| joint.shock.is_some()).collect();
    let unbonded: Vec<f64> = after.iter().map(|joint| joint.state.cracks[0] / length).collect();
    assert_eq!(
        after.iter().map(|joint| short_name(joint)).collect::<Vec<_>>(),
        ["after 1", "after 2", "after 3"]
    );
    assert!(after[2].name.ends_with(", after last"), "{}", after[2].name);
    for (found, wanted) in unbonded.iter().zip([0.3, 0.3, 0.6]) {
        assert!((found - wanted).abs() < 1e-9, "{unbonded:?}");
    }
    let rows = csv(&loaded.scene, &joints);
    assert_eq!(rows.lines().count(), 1 + 2 + 3, "usual, seismic, and after each shock: {rows}");
    let said = text(&loaded.scene, &joints, &shaken);
    assert!(said.contains("In last, from 7.03 to 9.00 s: least factor"), "{said}");

    // a run that ended in its second shock has no third one
    let (joints, shaken) = of_run(&loaded, &histories(&table[..5]), &[]).expect("joints");
    assert_eq!((shaken.len(), joints.iter().filter(|joint| joint.shock.is_some()).count()), (2, 2));
    assert_eq!(shaken[1][0].shock, Some(("shock 2".to_owned(), [begins[1], 4.0])));
    // one record, one state after it
    let (joints, shaken) = of_run(&read(&crop), &histories(&table), &[]).expect("joints");
    let after: Vec<_> =
        joints.iter().filter(|joint| joint.combination == LoadCombination::PostEarthquake).collect();
    assert!(shaken.len() == 1 && after.len() == 1 && short_name(after[0]) == "after", "{shaken:?}");
    assert!((after[0].state.cracks[0] / length - 0.6).abs() < 1e-9 && shaken[0][0].shock.is_none());
}
