//! Layouts of Foxglove: the configuration of each panel by its name, and a tree of panels.

use super::{COLOURS, Curve, Plot};
use serde_json::{Map, Value, json};

/// A panel for each plot, one below another, and the messages of the units at the bottom.
pub fn layout(plots: &[Plot]) -> String {
    let mut panels = Map::new();
    for (number, plot) in plots.iter().enumerate() {
        panels.insert(format!("Plot!cofferdam{number}"), panel(plot));
    }
    let messages = json!({ "topicToRender": "/log", "minLogLevel": 1, "searchTerms": [] });
    panels.insert("RosOut!cofferdam".to_owned(), messages);
    let mut names: Vec<String> = (0..plots.len()).map(|number| format!("Plot!cofferdam{number}")).collect();
    names.push("RosOut!cofferdam".to_owned());
    let layout = json!({
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": { "speed": 1 },
        "layout": column(&names),
    });
    format!("{layout:#}\n")
}

/// Panels one below another, all of the same height.
fn column(names: &[String]) -> Value {
    match names {
        [] => Value::Null,
        [name] => json!(name),
        [first, others @ ..] => json!({
            "direction": "column",
            "first": first,
            "second": column(others),
            "splitPercentage": 100.0 / names.len() as f64,
        }),
    }
}

fn panel(plot: &Plot) -> Value {
    let path = |(curve, colour): (&Curve, &&str)| {
        json!({
            "value": path(curve),
            "label": curve.label,
            "enabled": true,
            "timestampMethod": "receiveTime",
            "color": colour,
        })
    };
    json!({
        "title": plot.title,
        "paths": plot.curves.iter().zip(COLOURS.iter().cycle()).map(path).collect::<Vec<_>>(),
        "showXAxisLabels": true,
        "showYAxisLabels": true,
        "showLegend": true,
        "legendDisplay": "floating",
        "showPlotValuesInLegend": false,
        "isSynced": true,
        "xAxisVal": "timestamp",
        "sidebarDimension": 240,
    })
}

/// A path in Foxglove's syntax, with a filter for accepted values.
fn path(curve: &Curve) -> String {
    let filter = if curve.iterates { "{accepted==true}" } else { "" };
    let index = curve.index.map_or_else(String::new, |index| format!("[{index}]"));
    format!("{}{filter}.{}{index}", curve.topic, curve.field)
}
