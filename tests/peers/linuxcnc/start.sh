#!/bin/sh
# Runs LinuxCNC with the configuration beside this file, as root, until it is killed: in namespaces of its own (processes, shared memory,
# files in /tmp), so that nothing of it stays and a LinuxCNC that runs here already is not met. It does not run as root itself.
here=$(cd "$(dirname "$0")" && pwd)
[ "$1" = inside ] || exec unshare --pid --fork --kill-child=KILL --mount --mount-proc --ipc sh "$here/start.sh" inside
set -e
mount -t tmpfs tmpfs /mnt
mkdir -m 1777 /mnt/tmp
cp "$here"/bodies.* /mnt/
chown -R nobody /mnt
cd /mnt
mount --bind /mnt/tmp /tmp
mount -t tmpfs tmpfs /dev/shm
# Not by exec: this shell is the one whose end takes all others along.
setpriv --reuid nobody --regid nogroup --clear-groups env HOME=/tmp USER=nobody LC_ALL=C.UTF-8 linuxcnc bodies.ini </dev/null
