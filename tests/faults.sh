#!/usr/bin/env bash
# What a run leaves when it is killed, interrupted, or its disk fails: the last frame is readable, and a
# restart gives the frames and the ledger of the uninterrupted run, byte for byte.
#
#   tests/faults.sh BIPOT [KILLS [SEED]]        KILLS: of kill -9 (200), and a tenth of it of the others
#
# Ends with 0 when everything held; prints what it counted, and aloud what it had to leave out.
set -u
bipot="$1" kills="${2:-200}" seed="${3:-1}"
work="$(mktemp -d)"
trap 'umount "$work/small" "$work/locked" 2>/dev/null; chmod -R u+w "$work"; rm -rf "$work"' EXIT
RANDOM=$seed
failures=0
fail() { echo "FAILED: $*"; failures=$((failures + 1)); }

# Frames every 10 steps, so that most kills fall between two.
scene="$work/scene.toml"
sed -e 's/^every *=.*/every = 10/' "$(dirname "$0")/../data/scenes/compaction_100.toml" > "$scene"
endless=("$bipot" run "$scene" --solver pgs --tol 1e-2 --quiet)
run=("${endless[@]}" --steps 120)

begin=$(date +%s%N)
"${run[@]}" --out "$work/whole" >/dev/null 2>&1
whole_ms=$((($(date +%s%N) - begin) / 1000000))

# The folder holds the whole run.
same() {
  cmp -s "$work/whole/ledger.csv" "$1/ledger.csv" || { fail "$2: the ledger differs"; return 1; }
  for frame in "$work"/whole/frames/*.h5; do
    cmp -s "$frame" "$1/frames/$(basename "$frame")" || { fail "$2: $(basename "$frame") differs"; return 1; }
  done
}
# Goes on from what is there to the step where the whole run ended.
go_on() {
  local frame last=0
  for frame in "$1"/frames/*.h5; do last=$((10#$(basename "$frame" .h5))); done
  [ "$last" -ge 120 ] && return 0
  "$bipot" run "$scene" --restart "$1" --out "$1" --steps $((120 - last)) --solver pgs --tol 1e-2 --quiet \
    >/dev/null 2>"$work/error"
  local code=$?
  [ $code -le 1 ] || fail "$2: the restart from step $last ended with $code: $(cat "$work/error")"
}
sleep_ms() { sleep "$(printf '%d.%03d' $(($1 / 1000)) $(($1 % 1000)))"; }

struck=0
for ((k = 0; k < kills; ++k)); do
  rm -rf "$work/out"
  "${run[@]}" --out "$work/out" >/dev/null 2>&1 &
  pid=$!
  sleep_ms $((RANDOM * whole_ms / 32768))
  kill -9 $pid 2>/dev/null && struck=$((struck + 1))
  wait $pid 2>/dev/null
  # Before its first frame a run has nothing to go on from.
  compgen -G "$work/out/frames/*.h5" >/dev/null || { "${run[@]}" --out "$work/out" >/dev/null 2>&1; }
  go_on "$work/out" "kill -9 number $k" && same "$work/out" "kill -9 number $k"
done
echo "kill -9: $kills times at random ($struck met the run), frames and ledger after the restart identical"

for signal in TERM INT; do
  for ((k = 0; k < (kills + 9) / 10; ++k)); do
    rm -rf "$work/out"
    # A shell without job control starts background jobs deaf to SIGINT.
    setsid "${run[@]}" --out "$work/out" >/dev/null 2>&1 &
    pid=$!
    sleep_ms $((100 + RANDOM * whole_ms / 32768))
    kill -$signal $pid 2>/dev/null
    wait $pid 2>/dev/null
    compgen -G "$work/out/frames/*.h5" >/dev/null || { "${run[@]}" --out "$work/out" >/dev/null 2>&1; }
    go_on "$work/out" "SIG$signal number $k" && same "$work/out" "SIG$signal number $k"
  done
  echo "SIG$signal: $(((kills + 9) / 10)) times at random, frames and ledger after the restart identical"
done

# Refused or failed writes end with 4 and name the file.
expect_io() {
  local what="$1"; shift
  timeout 60 "$@" >/dev/null 2>"$work/error"
  local code=$?
  if [ $code -ne 4 ]; then fail "$what: exit code $code instead of 4: $(tail -1 "$work/error")"
  elif ! grep -q / "$work/error"; then fail "$what: no file is named: $(cat "$work/error")"
  else echo "$what: $(tail -1 "$work/error" | cut -c1-120)"; fi
}
mkdir "$work/locked"
if [ "$(id -u)" -ne 0 ]; then
  chmod a-w "$work/locked"
  expect_io "read-only folder" "${run[@]}" --out "$work/locked/out"
elif mount -t tmpfs -o ro tmpfs "$work/locked" 2>/dev/null; then  # root may write everywhere else
  expect_io "read-only folder" "${run[@]}" --out "$work/locked/out"
  umount "$work/locked"
else
  echo "read-only folder: left out, root may write everywhere and no tmpfs can be mounted here"
fi
touch "$work/file"
expect_io "a file where the folder should be" "${run[@]}" --out "$work/file/out"

rm -rf "$work/gone"
"${endless[@]}" --steps 100000 --out "$work/gone" >/dev/null 2>"$work/error" &
pid=$!
sleep_ms $((whole_ms / 3 + 200)); mv "$work/gone" "$work/taken" && rm -rf "$work/taken"
for ((k = 0; k < 300; ++k)); do kill -0 $pid 2>/dev/null || break; sleep 0.1; done
if kill -0 $pid 2>/dev/null; then kill -9 $pid; wait $pid 2>/dev/null; fail "folder removed: the run did not notice"
else wait $pid; code=$?
  [ $code -eq 4 ] && echo "folder removed during the run: $(tail -1 "$work/error" | cut -c1-120)" ||
    fail "folder removed: exit code $code: $(tail -1 "$work/error")"
fi

mkdir "$work/small"
if mount -t tmpfs -o size=300k tmpfs "$work/small" 2>/dev/null; then
  expect_io "disk full (tmpfs of 300 kB)" "${run[@]}" --out "$work/small/out"
  # What is there can be read, and the run goes on elsewhere.
  if compgen -G "$work/small/out/frames/*.h5" >/dev/null; then
    rm -rf "$work/moved"; cp -r "$work/small/out" "$work/moved"
    go_on "$work/moved" "after the full disk" && same "$work/moved" "after the full disk"
    echo "after the full disk: frames and ledger of the restart elsewhere identical"
  else fail "disk full: no frame is left"; fi
  umount "$work/small"
else
  echo "disk full: left out, no tmpfs can be mounted here"
fi
[ $failures -eq 0 ] && echo "all held" || { echo "$failures failures"; exit 1; }
