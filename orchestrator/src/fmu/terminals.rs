use super::model_description::{document, empty};
use super::{FmuError, SizedVariable};

/// Name of the terminal, and its kind: either unit has one, and importers connect equal members.
const TERMINAL: [(&str, &str); 4] = [
    ("name", "wet_face"),
    ("matchingRule", "bus"),
    ("terminalKind", "org.cofferdam.wet_face"),
    ("description", "what the dam and the reservoir exchange on the wet face"),
];

/// Variables of either unit that are members, if it has them; their names there are without this prefix.
const MEMBERS: [&str; 5] = [
    "interface_pressure",
    "hydrostatic_pressure",
    "interface_acceleration",
    "interface_displacement",
    "interface_velocity",
];
const PREFIX: &str = "interface_";

/// terminalsAndIcons.xml; nothing for a unit without a wet face.
pub fn write(variables: &[SizedVariable]) -> Result<Option<String>, FmuError> {
    let has = |name: &&str| variables.iter().any(|v| v.variable.name == *name);
    let members: Vec<&str> = MEMBERS.into_iter().filter(has).collect();
    if members.is_empty() {
        return Ok(None);
    }
    let text = document(|xml| {
        let root = xml.create_element("fmiTerminalsAndIcons").with_attribute(("fmiVersion", "3.0"));
        let content = root.write_inner_content(|xml| {
            let terminals = xml.create_element("Terminals").write_inner_content(|xml| {
                let terminal = xml.create_element("Terminal").with_attributes(TERMINAL);
                let members = terminal.write_inner_content(|xml| {
                    members.iter().try_for_each(|name| {
                        let member = name.strip_prefix(PREFIX).unwrap_or(name);
                        let attributes =
                            [("variableKind", "signal"), ("memberName", member), ("variableName", name)];
                        empty(xml, "TerminalMemberVariable", &attributes)
                    })
                });
                members.map(drop)
            });
            terminals.map(drop)
        });
        content.map(drop)
    })?;
    Ok(Some(text))
}
