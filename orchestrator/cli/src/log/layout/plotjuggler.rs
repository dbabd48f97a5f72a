//! Layouts of PlotJuggler: XML with a tab of plots, and how to load the log.

use super::{COLOURS, Curve, Plot};
use cofferdam_log::Head;
use quick_xml::escape::escape;
use std::fmt::Write;
use std::path::Path;

/// A plot below another in one tab, and the log with the topics to load.
pub fn layout(plots: &[Plot], log: &Path, head: &Head) -> String {
    let share = format!("{:.6}", 1.0 / plots.len() as f64);
    let sizes = vec![share; plots.len()].join(";");
    let areas: String = plots.iter().map(area).collect();
    let log = std::fs::canonicalize(log).unwrap_or_else(|_| log.to_owned()).display().to_string();
    let answers = head.units.iter().map(|unit| format!("/{}/answer", unit.name));
    let topics = answers.chain(["/step".to_owned()]).collect::<Vec<_>>().join(";");
    let longest = head.units.iter().map(|unit| unit.outputs.longest()).max().unwrap_or(0).max(500);
    format!(
        r#"<?xml version='1.0' encoding='UTF-8'?>
<root>
 <tabbed_widget name="Main Window" parent="main_window">
  <Tab tab_name="cofferdam" containers="1">
   <Container>
    <DockSplitter orientation="-" count="{count}" sizes="{sizes}">
{areas}    </DockSplitter>
   </Container>
  </Tab>
  <currentTabIndex index="0"/>
 </tabbed_widget>
 <use_relative_time_offset enabled="0"/>
 <previouslyLoaded_Datafiles>
  <fileInfo filename="{log}" prefix="">
   <selected_datasources value=""/>
   <plugin ID="DataLoad MCAP">
    <parameters use_timestamp="0" use_mcap_log_time="0" clamp_large_arrays="1" max_array_size="{longest}" selected_topics="{topics}"/>
   </plugin>
  </fileInfo>
 </previouslyLoaded_Datafiles>
</root>
"#,
        count = plots.len(),
        log = escape(&log),
        topics = escape(&topics),
    )
}

fn area(plot: &Plot) -> String {
    let mut text = format!("     <DockArea name=\"{}\">\n", escape(plot.title));
    text.push_str("      <plot mode=\"TimeSeries\" style=\"Lines\" flip_x=\"false\" flip_y=\"false\">\n");
    text.push_str("       <limitY/>\n");
    for (curve, colour) in plot.curves.iter().zip(COLOURS.iter().cycle()) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "       <curve name=\"{}\" color=\"{colour}\"/>", escape(path(curve)));
    }
    text.push_str("      </plot>\n     </DockArea>\n");
    text
}

/// The name that PlotJuggler gives a field.
fn path(curve: &Curve) -> String {
    let index = curve.index.map_or_else(String::new, |index| format!("[{index}]"));
    format!("{}/{}{index}", curve.topic, curve.field)
}
