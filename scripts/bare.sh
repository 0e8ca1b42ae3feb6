# For scripts that try something on a bare Debian: source it, call make_bare FOLDER [RELEASE], then inside COMMANDS. Needs root.
# shellcheck shell=bash

# Makes a bare Debian in the folder with debootstrap, a new one each time, with a fresh proc and nothing else of the machine, and
# an empty folder /trial. RELEASE: bookworm (Debian 12) or trixie (Debian 13).
make_bare() {
  local release="${2:-bookworm}"
  is_release "$release" || { echo "$0: no release '$release'; bookworm or trixie" >&2; exit 2; }
  bare="$(realpath -m "$1")"
  ((EUID == 0)) || { echo "$0: chroot needs root" >&2; exit 2; }
  [[ ! -e "$bare" || -e "$bare/etc/debian_version" ]] || { echo "$bare is there, and no Debian; name another folder" >&2; exit 2; }
  command -v debootstrap >/dev/null || { apt-get update && apt-get install --yes --no-install-recommends debootstrap; }
  trap leave_bare EXIT
  leave_bare
  ! grep -qF " $bare/" /proc/mounts || { echo "$bare has something mounted; unmount it first" >&2; exit 2; }
  rm -rf --one-file-system "$bare"
  mkdir -p "$(dirname "$bare")"
  debootstrap --variant=minbase "$release" "$bare" >"$bare.log" || { tail "$bare.log" >&2; exit 1; }
  mount -t proc proc "$bare/proc"
  mkdir -p "$bare/trial"
}

leave_bare() { [[ -z "${bare:-}" ]] || umount "$bare/proc" 2>/dev/null || true; }

is_release() { [[ "$1" == bookworm || "$1" == trixie ]]; }

# Reads [--release RELEASE] [FOLDER] into `release` and `folder`.
read_bare_arguments() {
  local usage="usage: $0 [--release bookworm | trixie] [FOLDER]"
  release=bookworm
  if [[ "${1:-}" == --release ]]; then
    release="${2:-}"
    is_release "$release" || { echo "$usage" >&2; exit 2; }
    shift 2
  fi
  [[ $# -le 1 && "${1:-}" != -* ]] || { echo "$usage" >&2; exit 2; }
  # shellcheck disable=SC2034
  folder="${1:-build/bare}"
}

# Configuration of this machine's network for the bare system: certificates only.
take_certificates() {
  [[ ! -d /usr/local/share/ca-certificates ]] || cp -r /usr/local/share/ca-certificates "$bare/usr/local/share/"
  inside 'apt-get update >/dev/null && apt-get install --yes --no-install-recommends ca-certificates >/dev/null
    update-ca-certificates >/dev/null'
}

# Runs commands of bash there; further arguments are $1 and so on.
inside() {
  chroot "$bare" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    bash -euo pipefail -c "$1" bash "${@:2}"
}
