# Prints where a file or folder is that an argument of a launch file names, as seen from where roslaunch was called: nodes work
# elsewhere. Where it is not there, it says so and fails, which ends the launch (`<param command="..."/>`).
#   bash absolute.bash ARGUMENT PATH
set -euo pipefail

argument=$1
path=$2
case $path in
    '~') path=$HOME ;;
    '~/'*) path=$HOME/${path#'~/'} ;;
esac
if [ -z "$path" ]; then
    echo "$argument:=PATH is missing" >&2
    exit 1
fi
if [ ! -e "$path" ]; then
    echo "$argument:=$2: there is no such file or folder, seen from $PWD; give its absolute path" >&2
    exit 1
fi
printf '%s' "$(realpath -- "$path")"
