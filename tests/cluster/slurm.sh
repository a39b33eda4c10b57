# start_slurm: a Slurm of one node, this machine, in $work, with its own munge; ended by clean_up through `daemons`. Returns 1, with
# the reason in slurm_problem, where it cannot.
# lose_node: the node's processes are killed for good, its daemon and jobs; then it comes back, without jobs.
start_slurm() {
    local tool
    slurm_problem=""
    for tool in munged slurmctld slurmd sbatch sinfo; do
        PATH="$PATH:/usr/sbin" command -v $tool >/dev/null || { slurm_problem="no $tool (slurm-wlm, munge)"; return 1; }
    done
    [[ $(id -u) == 0 ]] || { slurm_problem="it needs root"; return 1; }
    local slurm=$work/slurm host
    host=$(hostname -s)
    mkdir -p "$slurm"/{state,spool,munge}
    chmod 755 "$work" "$slurm" "$slurm/munge"
    dd if=/dev/urandom of="$slurm/munge/key" bs=1024 count=1 status=none
    chmod 600 "$slurm/munge/key"
    /usr/sbin/munged --foreground --force --key-file="$slurm/munge/key" --socket="$slurm/munge/socket" \
        --pid-file="$slurm/munge/pid" --log-file="$slurm/munge/log" --seed-file="$slurm/munge/seed" &> "$slurm/munge/out" &
    daemons+=($!)
    cat > "$slurm/slurm.conf" <<END
ClusterName=hexrelief
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$slurm/munge/socket,cred_expire=5
CredType=cred/munge
SlurmctldPort=26817
SlurmdPort=26818
StateSaveLocation=$slurm/state
SlurmdSpoolDir=$slurm/spool
SlurmctldPidFile=$slurm/slurmctld.pid
SlurmdPidFile=$slurm/slurmd.pid
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerParameters=batch_sched_delay=0,sched_interval=1
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
ReturnToService=2
MinJobAge=300
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 RealMemory=2000 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
END
    # No job is held by a control group here, but slurmd wants to know which kind there is.
    local groups=cgroup/v1
    [[ $(stat -fc %T /sys/fs/cgroup) == cgroup2fs ]] && groups=cgroup/v2
    echo "CgroupPlugin=$groups" > "$slurm/cgroup.conf"
    export SLURM_CONF=$slurm/slurm.conf
    /usr/sbin/slurmctld -D -c &> "$slurm/slurmctld.log" &
    daemons+=($!)
    start_slurmd && return 0
    slurm_problem=$(tail -n 3 "$slurm"/slurmctld.log "$slurm"/slurmd.log "$slurm"/munge/out 2>&1 | tr '\n' ' ')
    return 1
}

# Until the node takes jobs.
start_slurmd() {
    /usr/sbin/slurmd -D -N "$(hostname -s)" &>> "$work/slurm/slurmd.log" &
    slurmd=$!
    daemons+=($slurmd)
    for _ in {1..60}; do
        [[ $(sinfo -h -o %T 2>/dev/null) =~ ^(idle|mixed|allocated)$ ]] && return 0
        sleep 0.5
    done
    return 1
}

lose_node() {
    local pid
    kill -9 "$slurmd"
    for pid in $(pgrep -x slurmstepd); do
        grep -qz "^SLURM_CONF=$work/slurm/" "/proc/$pid/environ" 2>/dev/null && kill -9 "$pid"
    done
    for pid in $(processes); do kill -9 "$pid" 2>/dev/null || true; done
    touch "$work/slurm/lost"  # when it was
    # What the controller would find by itself after some minutes.
    scontrol update "nodename=$(hostname -s)" state=down reason=lost
    scontrol update "nodename=$(hostname -s)" state=resume
    start_slurmd || fail "Slurm's node does not come back: $(tail -n 3 "$work/slurm/slurmd.log")"
}
