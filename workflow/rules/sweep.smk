# Exit status 7: some beds failed, and failures.csv lists them. 4: a tolerance was not reached.
# Neither is a reason to run a job again.
ENOUGH = "case $? in 0|4|7) ;; *) exit 1 ;; esac"


rule program:
    """Jobs run a copy, so that an update does not change the program under their feet."""
    output:
        program=f"{WORK}/soilsig",
    params:
        program=config["soilsig"],
    localrule: True
    shell:
        'cp -p "$(command -v {params.program:q})" {output.program:q}'


rule part:
    """Drops and traces one part of the beds. A job that was ended goes on where it was."""
    input:
        study=STUDY,
        program=rules.program.output.program,
    output:
        done=touch(f"{WORK}/{{part}}.done"),
    log:
        f"{WORK}/{{part}}.log",
    params:
        out=OUT,
        parts=PARTS,
        options=config["options"],
    threads: config["threads"]
    resources:
        runtime=config["minutes"],
        mem_mb=config["memory_mb"],
    shell:
        "set +e; {input.program:q} sweep {input.study:q} --out {params.out:q} "
        "--part {wildcards.part}/{params.parts} --threads {threads} {params.options} "
        f">{{log:q}} 2>&1; {ENOUGH}"


rule results:
    """Tables, charts and page of all beds."""
    input:
        study=STUDY,
        program=rules.program.output.program,
        parts=expand(f"{WORK}/{{part}}.done", part=range(1, PARTS + 1)),
    output:
        [
            report(f"{OUT}/{file}", caption=f"../report/{text}.rst", category="Results")
            for file, text in SHOWN.items()
        ],
        [f"{OUT}/{file}" for file in RESULTS if file not in SHOWN],
    log:
        f"{WORK}/results.log",
    params:
        out=OUT,
        options=config["options"],
    threads: config["threads"]
    resources:
        runtime=config["minutes"],
        mem_mb=config["memory_mb"],
    shell:
        "set +e; {input.program:q} sweep {input.study:q} --out {params.out:q} "
        "--threads {threads} {params.options} "
        f">{{log:q}} 2>&1; {ENOUGH}"
