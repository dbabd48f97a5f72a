use super::xml::{document, empty};
use super::{FmuError, SizedVariable};

/// The terminals: name, what the names of their variables begin with, description. Importers connect members of the same
/// name; every water has the first terminal only.
const TERMINALS: [[&str; 3]; 2] = [
    ["wet_face", "", "variables that dam and reservoir exchange on the wet face"],
    [
        "tailwater_wet_face",
        "tailwater_",
        "variables that dam and tailwater exchange on the downstream wet face",
    ],
];
const KIND: &str = "org.cofferdam.wet_face";

/// Variables that become members of a terminal if the unit has them. Member names leave out the terminal's prefix and
/// [`PREFIX`].
const MEMBERS: [&str; 11] = [
    "interface_pressure",
    "hydrostatic_pressure",
    "interface_acceleration",
    "interface_acceleration_end",
    "interface_displacement",
    "interface_velocity",
    "interface_x",
    "interface_y",
    "interface_normal_x",
    "interface_normal_y",
    "interface_length",
];
const PREFIX: &str = "interface_";

/// The text of terminalsAndIcons.xml; none for a unit without a wet face.
pub fn write(variables: &[SizedVariable]) -> Result<Option<String>, FmuError> {
    let has = |name: &String| variables.iter().any(|v| v.variable.name == *name);
    let members = |prefix: &str| MEMBERS.map(|name| format!("{prefix}{name}")).into_iter().filter(has);
    let terminals: Vec<_> =
        TERMINALS.iter().filter(|[_, prefix, _]| members(prefix).next().is_some()).collect();
    if terminals.is_empty() {
        return Ok(None);
    }
    let text = document(|xml| {
        let root = xml.create_element("fmiTerminalsAndIcons").with_attribute(("fmiVersion", "3.0"));
        let content = root.write_inner_content(|xml| {
            let all = xml.create_element("Terminals").write_inner_content(|xml| {
                terminals.iter().try_for_each(|[name, prefix, description]| {
                    let attributes = [
                        ("name", *name),
                        ("matchingRule", "bus"),
                        ("terminalKind", KIND),
                        ("description", *description),
                    ];
                    let terminal = xml.create_element("Terminal").with_attributes(attributes);
                    let written = terminal.write_inner_content(|xml| {
                        members(prefix).try_for_each(|name| {
                            let member = name.strip_prefix(prefix).unwrap_or(&name);
                            let member = member.strip_prefix(PREFIX).unwrap_or(member);
                            let attributes =
                                [("variableKind", "signal"), ("memberName", member), ("variableName", &name)];
                            empty(xml, "TerminalMemberVariable", &attributes)
                        })
                    });
                    written.map(drop)
                })
            });
            all.map(drop)
        });
        content.map(drop)
    })?;
    Ok(Some(text))
}
