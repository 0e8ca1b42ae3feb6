# For scripts that try something on a bare Debian 12: source it, call make_bare FOLDER, then inside COMMANDS. Needs root.
# shellcheck shell=bash

# Makes a bare Debian 12 in the folder with debootstrap, a new one each time, with a fresh proc and nothing else of the
# machine, and an empty folder /trial.
make_bare() {
  bare="$(realpath -m "$1")"
  ((EUID == 0)) || { echo "$0: chroot needs root" >&2; exit 2; }
  [[ ! -e "$bare" || -e "$bare/etc/debian_version" ]] || { echo "$bare is there, and no Debian; name another folder" >&2; exit 2; }
  command -v debootstrap >/dev/null || { apt-get update && apt-get install --yes --no-install-recommends debootstrap; }
  trap leave_bare EXIT
  leave_bare
  rm -rf --one-file-system "$bare"
  mkdir -p "$(dirname "$bare")"
  debootstrap --variant=minbase bookworm "$bare" >"$bare.log" || { tail "$bare.log" >&2; exit 1; }
  mount -t proc proc "$bare/proc"
  mkdir -p "$bare/trial"
}

leave_bare() { umount "$bare/proc" 2>/dev/null || true; }

# Runs commands of bash there.
inside() {
  chroot "$bare" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    bash -euo pipefail -c "$1"
}
