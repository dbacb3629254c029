# Runs a command in the workspace that this file belongs to, with ROS_IP set to the address by which this computer reaches
# the ROS master, unless it is set already. roslaunch runs it on each computer (`env-loader`); by hand:
#   bash env_loader.bash roslaunch deformable_cobot arm.launch
set -eo pipefail

main() {
    if [ -z "${ROS_IP:-}" ]; then
        ROS_IP=$(own_address)
        export ROS_IP
    fi
    # A name would be told to others in place of the address.
    unset ROS_HOSTNAME
    # Its lines read unset variables and may fail without harm.
    set +e
    . "$(find_setup)"
    exec "$@"
}

# Where the route to the master begins.
own_address() {
    local host address
    host=${ROS_MASTER_URI:-http://localhost:11311}
    host=${host#http://}
    host=${host%%[:/]*}
    address=$(getent ahostsv4 "$host" | cut --delimiter=' ' --fields=1 | head --lines=1) ||
        fail "cannot resolve '$host' of ROS_MASTER_URI"
    address=$(ip -4 -oneline route get "$address" 2>&1) ||
        fail "no way to the ROS master at $host ($address); see to the network, or set ROS_IP"
    sed --quiet --regexp-extended 's/.* src ([0-9.]+).*/\1/p' <<<"$address"
}

# The nearest set-up file above: of an installation, of the checkout's own workspace, or of one that the checkout lies in.
find_setup() {
    local folder
    folder=$(dirname "$(realpath "${BASH_SOURCE[0]}")")
    while [ "$folder" != / ]; do
        folder=$(dirname "$folder")
        for file in "$folder"/{,devel/,target/catkin/devel/}setup.bash; do
            if [ -e "$file" ]; then
                echo "$file"
                return
            fi
        done
    done
    fail "no setup.bash of a workspace above ${BASH_SOURCE[0]}; build the package on this computer first (make build)"
}

fail() {
    echo "env_loader on $(hostname): $*" >&2
    exit 1
}

main "$@"
