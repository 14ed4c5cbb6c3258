#!/usr/bin/env bash
# A virtual machine with Debian's own kernel, for tests against real kernel code: drivers, file systems, power cuts.
#
#   machine.sh prepare CACHE
#       Once: fetches the kernel package into CACHE and makes a small initial file system. Needs the package mirror.
#   machine.sh run CACHE PROGRAM WORK SCRIPT [QEMU ARGUMENTS...]
#       Boots and runs SCRIPT (a file in WORK) as root. The guest sees this machine's root file system read-only; PROGRAM (a
#       build tree) as /media, read-only; WORK as /mnt, writable; CACHE as /srv; nothing of /tmp and /run. "$MP MODULE" loads a
#       kernel module. The guest's console goes to stderr, SCRIPT's exit status to WORK/status. No network.
#
# The processor is emulated (TCG): about 5 s from here to SCRIPT, and everything 5 to 20 times slower. Killing this process is
# pulling the machine's plug: it is qemu itself by then.
set -euo pipefail

prepare() {
  local cache package version offset root module file
  cache=$(realpath -m "$1")
  [ -f "$cache/ready" ] && return 0
  mkdir -p "$cache"
  cd "$cache"
  package=$(apt-cache depends linux-image-amd64 | awk '/Depends: linux-image-6/ {print $2; exit}')
  apt-get -o APT::Sandbox::User=root download "$package"
  rm -rf kernel
  dpkg-deb -x "$package"*.deb kernel
  rm -f "$package"*.deb
  version=$(ls kernel/lib/modules)
  depmod -b kernel "$version"
  # The bare kernel boots without unpacking itself: 2.5 s instead of 10 on an emulated processor.
  offset=$(LC_ALL=C grep -aobP '\xFD7zXZ\x00' "kernel/boot/vmlinuz-$version" | head -n 1 | cut -d: -f1)
  tail -c "+$((offset + 1))" "kernel/boot/vmlinuz-$version" | xz -dc >vmlinux 2>/dev/null || true  # more follows the kernel
  root=$(mktemp -d)
  mkdir -p "$root"/{bin,proc,sys,dev,new,modules}
  cp /bin/busybox "$root/bin/"
  for file in sh mount insmod switch_root; do ln -s busybox "$root/bin/$file"; done
  for module in virtio_pci 9pnet_virtio 9p; do
    modprobe -d kernel -S "$version" -n --show-depends "$module" | awk '/^insmod/ {print $2}'
  done | while read -r file; do
    module=$(basename "$file")
    [ -e "$root/modules/$module" ] && continue
    cp "$file" "$root/modules/$module"
    echo "$module" >>"$root/modules/order"
  done
  cat >"$root/init" <<'INIT'
#!/bin/sh
mount -t proc proc /proc
mount -t sysfs sys /sys
mount -t devtmpfs dev /dev
while read module; do insmod /modules/$module; done < /modules/order
options=trans=virtio,version=9p2000.L,msize=512000
mount -t 9p -o ro,$options,cache=loose root /new
for folder in tmp run var/tmp; do mount -t tmpfs tmpfs /new/$folder; done
mount -t 9p -o $options,cache=none work /new/mnt
mount -t 9p -o ro,$options,cache=loose cache /new/srv
mount -t 9p -o ro,$options,cache=loose program /new/media
for folder in proc sys dev; do mount --move /$folder /new/$folder; done
exec switch_root /new /bin/sh /mnt/.init
INIT
  chmod +x "$root/init"
  (cd "$root" && find . | cpio -o -H newc --quiet | gzip -1) >initial.gz
  rm -rf "$root"
  touch ready
}

run() {
  local cache program work script
  cache=$(realpath "$1")
  program=$(realpath "$2")
  work=$(realpath "$3")
  script=$4
  shift 4
  rm -f "$work/status"
  cat >"$work/.init" <<INIT
export PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/tmp MP="modprobe -d /srv/kernel"
mkdir -p /dev/pts /dev/shm
mount -t devpts devpts /dev/pts
mount -t tmpfs tmpfs /dev/shm
ip link set lo up
bash /mnt/$script
echo \$? > /mnt/status
echo o > /proc/sysrq-trigger
while :; do :; done
INIT
  exec qemu-system-x86_64 -accel tcg,thread=multi -cpu max -smp 2 -M q35 -m 1024 -display none -nodefaults -no-reboot \
    -nic none -kernel "$cache/vmlinux" -initrd "$cache/initial.gz" \
    -append "console=ttyS0 quiet panic=-1 mitigations=off nokaslr" -serial stdio \
    -virtfs local,path=/,mount_tag=root,security_model=none,readonly=on,multidevs=remap \
    -virtfs local,path="$cache",mount_tag=cache,security_model=none,readonly=on \
    -virtfs local,path="$program",mount_tag=program,security_model=none,readonly=on \
    -virtfs local,path="$work",mount_tag=work,security_model=none -device virtio-rng-pci "$@" </dev/null 1>&2
}

command=${1:-}
[ $# -gt 0 ] && shift
case $command in
  prepare | run) "$command" "$@" ;;
  *)
    sed -n '2,/^set -/p' "$0" | grep '^#' >&2
    exit 2
    ;;
esac
