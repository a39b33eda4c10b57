# start_slurm: a Slurm of one node, this machine, in $work, with its own munge; ended by clean_up through `daemons`. Returns 1, with
# the reason in slurm_problem, where it cannot.
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
AuthInfo=socket=$slurm/munge/socket
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
    /usr/sbin/slurmd -D -N "$host" &> "$slurm/slurmd.log" &
    daemons+=($!)
    for _ in {1..60}; do
        [[ $(sinfo -h -o %T 2>/dev/null) == idle ]] && return 0
        sleep 0.5
    done
    slurm_problem=$(tail -n 3 "$slurm"/slurmctld.log "$slurm"/slurmd.log "$slurm"/munge/out 2>&1 | tr '\n' ' ')
    return 1
}
