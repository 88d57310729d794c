//! A Slurm of two nodes on this machine, which ends with its value.

use std::fs;
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Programs that find the cluster by themselves.
const CLIENTS: [&str; 7] = ["sbatch", "srun", "squeue", "scancel", "scontrol", "sinfo", "sacct"];

/// The cluster.
pub struct Slurm {
    folder: tempfile::TempDir,
    running: Vec<Child>,
}

impl Slurm {
    /// Starts it, and waits for its nodes.
    pub fn start() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut slurm = Self { folder, running: Vec::new() };
        for name in ["munge", "state", "bin"] {
            fs::create_dir(slurm.at(name)).expect("made");
        }
        fs::set_permissions(slurm.at("munge"), fs::Permissions::from_mode(0o700)).expect("set");
        slurm.write("munge/key", &"soilsig ".repeat(128), 0o600);
        slurm.write("slurm.conf", &slurm.config(), 0o644);
        for client in CLIENTS {
            let config = slurm.at("slurm.conf");
            let place = program(client);
            let text = format!(
                "#!/bin/sh\nSLURM_CONF='{}' exec '{}' \"$@\"\n",
                config.display(),
                place.display()
            );
            slurm.write(&format!("bin/{client}"), &text, 0o755);
        }
        let munge = |option: &str, file: &str| {
            format!("--{option}={}", slurm.at(&format!("munge/{file}")).display())
        };
        let options = [
            munge("key-file", "key"),
            munge("socket", "socket"),
            munge("pid-file", "pid"),
            munge("log-file", "log"),
            munge("seed-file", "seed"),
        ];
        let munged: Vec<&str> = options.iter().map(String::as_str).collect();
        slurm.run("munged", &[&["--foreground", "--force"], &munged[..]].concat());
        slurm.wait("munged", |slurm| slurm.at("munge/socket").exists());
        slurm.run("slurmctld", &["-D", "-i"]);
        slurm.run("slurmd", &["-D", "-N", "one"]);
        slurm.run("slurmd", &["-D", "-N", "two"]);
        slurm.wait("slurmctld", |slurm| {
            slurm.says("scontrol", &["show", "nodes"]).matches("State=IDLE ").count() == 2
        });
        slurm
    }

    fn config(&self) -> String {
        let here = self.folder.path().display();
        let user = Command::new("id").arg("-un").output().expect("it starts").stdout;
        let user = String::from_utf8(user).expect("a name");
        let user = user.trim();
        // Ports that were free a moment ago.
        let listeners = [(); 3].map(|()| TcpListener::bind("127.0.0.1:0").expect("a free port"));
        let [control, one, two] =
            listeners.map(|of| of.local_addr().expect("it has an address").port());
        format!(
            "ClusterName=test
SlurmctldHost=localhost(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={here}/munge/socket
SlurmctldPort={control}
SlurmctldPidFile={here}/slurmctld.pid
SlurmctldLogFile={here}/slurmctld.log
SlurmdPidFile={here}/%n.pid
SlurmdLogFile={here}/%n.log
SlurmdSpoolDir={here}/spool_%n
StateSaveLocation={here}/state
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
ReturnToService=2
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MinJobAge=600
SchedulerParameters=sched_interval=1,bf_interval=1
NodeName=one NodeHostname=localhost NodeAddr=127.0.0.1 Port={one} CPUs=1 RealMemory=100000
NodeName=two NodeHostname=localhost NodeAddr=127.0.0.1 Port={two} CPUs=1 RealMemory=100000
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"
        )
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str, mode: u32) {
        fs::write(self.at(name), text).expect("written");
        fs::set_permissions(self.at(name), fs::Permissions::from_mode(mode)).expect("set");
    }

    fn run(&mut self, name: &str, args: &[&str]) {
        let log = fs::File::create(self.at(&format!("{name}{}.out", self.running.len())));
        let mut command = Command::new(program(name));
        command.args(args).env("SLURM_CONF", self.at("slurm.conf")).stdin(Stdio::null());
        command.stdout(Stdio::null()).stderr(log.expect("made"));
        self.running.push(command.spawn().expect("it starts"));
    }

    /// Waits until something holds; else tells what the daemons wrote.
    fn wait(&self, of: &str, holds: impl Fn(&Self) -> bool) {
        let until = Instant::now() + Duration::from_secs(180);
        while !holds(self) {
            if Instant::now() > until {
                let files = fs::read_dir(self.folder.path()).expect("a folder").flatten();
                let is_log =
                    |path: &PathBuf| path.extension().is_some_and(|of| of == "out" || of == "log");
                let logs = files.map(|file| file.path()).filter(is_log);
                let said: Vec<String> =
                    logs.filter_map(|log| fs::read_to_string(log).ok()).collect();
                panic!("{of} is not ready: {}", said.join("\n"));
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// What a client prints.
    pub fn says(&self, client: &str, args: &[&str]) -> String {
        let output = Command::new(self.bin().join(client)).args(args).output();
        String::from_utf8(output.expect("it starts").stdout).expect("text")
    }

    /// The folder of the clients.
    pub fn bin(&self) -> PathBuf {
        self.at("bin")
    }
}

impl Drop for Slurm {
    fn drop(&mut self) {
        for child in self.running.iter_mut().rev() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// A program of the system; daemons are not on everyone's PATH.
fn program(name: &str) -> PathBuf {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&path).chain([Path::new("/usr/sbin").to_owned()]);
    let places = folders.map(|folder| folder.join(name));
    places.into_iter().find(|place| place.exists()).unwrap_or_else(|| panic!("{name} is missing"))
}
