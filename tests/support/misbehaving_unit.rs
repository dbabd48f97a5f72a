//! A unit's process that breaks the protocol in the way that its argument names.

use cofferdam_coupling::participant::{Channel, ChannelShape, Description, Layout};
use cofferdam_shared_memory::transport::{Command, Folder, PROTOCOL_VERSION, Server, Status};
use cofferdam_shared_memory::{Task, Word, layout_hash};
use cofferdam_unit::{Capabilities, Fingerprint};
use std::io::{BufRead, Write};
use std::sync::atomic::AtomicBool;

fn main() {
    let fault = std::env::args().nth(1).expect("a fault");
    let mut line = String::new();
    std::io::stdin().lock().read_line(&mut line).expect("standard input");
    let task: Task = serde_json::from_str(&line).expect("a task");
    let channel = |name: &str| {
        let (name, unit) = (name.to_owned(), String::new());
        Layout::new(vec![Channel { name, value_reference: 1, unit, size: 3, shape: ChannelShape::List }])
    };
    let description = Description {
        name: task.unit.clone(),
        solver: fault.clone(),
        fingerprint: Fingerprint::of("misbehaving", &fault).expect("a fingerprint"),
        inputs: channel("x"),
        outputs: channel("y"),
        readable: channel("z"),
        capabilities: Capabilities {
            variable_communication_step: true,
            directional_derivative: false,
            saved_state: true,
        },
    };
    let description = match &*fault {
        "without-states" => {
            let capabilities = Capabilities { saved_state: false, ..description.capabilities };
            Description { capabilities, ..description }
        }
        _ => description,
    };
    let layout = layout_hash(&description);
    let announced = serde_json::to_value(&description).expect("a description");
    let ready = |protocol, description| say(&Word::Ready { protocol, description });
    let folder = Folder::join(&task.folder, task.run).expect("the folder of the run");
    let server =
        |layout: &str| Server::create(&folder, &task.service, &task.unit, layout, 8).expect("a server");
    match &*fault {
        "old-version" => return ready(PROTOCOL_VERSION + 1, serde_json::Value::Null),
        "no-description" => return ready(PROTOCOL_VERSION, serde_json::Value::from("none")),
        "no-service" => {
            ready(PROTOCOL_VERSION, announced);
            return wait();
        }
        "other-layout" => {
            let _server = server("0123");
            ready(PROTOCOL_VERSION, announced);
            return wait();
        }
        "silent" => return wait(),
        "exits" => std::process::exit(7),
        "panics" => panic!("this unit panics"),
        "chatters" => loop {
            println!("this line is no JSON");
            std::thread::sleep(std::time::Duration::from_millis(1));
        },
        "other-name" => {
            let description = Description { name: "dyke".to_owned(), ..description };
            return ready(PROTOCOL_VERSION, serde_json::to_value(&description).expect("a description"));
        }
        _ => {}
    }
    println!("this line is no JSON");
    std::io::stdout().write_all(b"caf\xe9\n").expect("standard output");
    let server = server(&layout);
    ready(PROTOCOL_VERSION, announced);
    println!("nor is this one");
    let serve =
        |header: &mut cofferdam_shared_memory::transport::Header, inputs: &[f64], outputs: &mut Vec<f64>| {
            outputs.extend_from_slice(inputs);
            match (&*fault, header.step) {
                ("dies-when-serialised", _) if header.command() == Some(Command::Serialise) => {
                    std::fs::write(folder.path().join("dam.state"), "half a st").expect("a file");
                    std::process::abort()
                }
                ("writes-no-state", _) => {}
                (fault, _) if header.command > Command::RestoreAndStep as u32 => match fault {
                    "hangs-when-serialised" => wait(),
                    _ => header.status = Status::NotOffered as u32,
                },
                ("without-states", 1) => assert_eq!(header.command(), Some(Command::Step)),
                ("short-answer", 1) => drop(outputs.pop()),
                ("wrong-echo", 1) => header.time += 0.5,
                ("not-finite", 1) => outputs[2] = f64::INFINITY,
                ("fails-silently", 1) => header.status = Status::Failed as u32,
                ("miscounts-words", _) => header.words = 99,
                ("warns-and-dies", 1) => {
                    say(&Word::Failed { text: "dam: it is too much".to_owned() });
                    std::process::abort();
                }
                ("promises-words", 1) => (header.status, header.words) = (Status::Failed as u32, 99),
                ("hangs", 1) => wait(),
                ("dies", 1) => std::process::abort(),
                ("knows-no-places", _) if header.command() == Some(Command::Read) => {
                    outputs.extend([5.0, 6.0, 7.0]);
                }
                ("dies-when-read", _) if header.command() == Some(Command::Read) => std::process::abort(),
                _ => {}
            }
        };
    server.serve(&AtomicBool::new(false), serve).expect("it serves");
}

fn say(word: &Word) {
    println!("{}", serde_json::to_string(word).expect("JSON"));
}

/// Does nothing until it is killed.
fn wait() {
    loop {
        std::thread::park();
    }
}
