use super::model_description::{document, empty};
use super::{FmuError, SizedVariable};

/// Attributes of the terminal. Both units have it; importers connect members of the same name.
const TERMINAL: [(&str, &str); 4] = [
    ("name", "wet_face"),
    ("matchingRule", "bus"),
    ("terminalKind", "org.cofferdam.wet_face"),
    ("description", "variables that dam and reservoir exchange on the wet face"),
];

/// Variables that become members of the terminal if the unit has them. Member names leave out [`PREFIX`].
const MEMBERS: [&str; 5] = [
    "interface_pressure",
    "hydrostatic_pressure",
    "interface_acceleration",
    "interface_displacement",
    "interface_velocity",
];
const PREFIX: &str = "interface_";

/// The text of terminalsAndIcons.xml; none for a unit without a wet face.
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
