#!/usr/bin/env bash
# Opens the window of `halfdome view` under Xvfb, sends it keys and clicks, and compares what it shows with what
# `halfdome render` writes, to the bit. HALFDOME names a program that was built with the feature `view`; without it one is built.
# A folder as argument gets the screenshots.
set -euo pipefail
cd "$(dirname "$0")/.."

.ci/install Xvfb xvfb xdotool xdotool import imagemagick
# What the window loads at run time.
has() { ldconfig -p | grep -q "$1" && echo true || echo "$1"; }
.ci/install "$(has libxkbcommon-x11)" libxkbcommon-x11-0 "$(has libXcursor)" libxcursor1 "$(has 'libXi\.')" libxi6 \
    "$(has libX11-xcb)" libx11-xcb1
if [ -z "${HALFDOME:-}" ]; then
    cargo build --release -p halfdome --features view
    HALFDOME=target/release/halfdome
fi
work=$(mktemp -d)
shots=${1:-$work}
viewer=
server=
trap 'kill $viewer $server 2> /dev/null || true; rm -rf "$work"' EXIT
fail() { echo "view.sh: $1" >&2; exit 1; }

# Without a display there is a word and a code.
code=0
env -u DISPLAY -u WAYLAND_DISPLAY -u WAYLAND_SOCKET "$HALFDOME" view cornell 2> "$work/error" || code=$?
[ $code -eq 2 ] || fail "without a display the exit code is $code"
grep -q "no display" "$work/error" || fail "without a display it says: $(cat "$work/error")"

# Two walls, a floor and a lamp: a model that has a camera by its bounds alone.
cat > "$work/room.obj" << 'END'
o floor
v -1 0 -1
v 1 0 -1
v 1 0 1
v -1 0 1
f 4 3 2 1
o wall
v -1 2 -1
v 1 2 -1
f 1 2 6 5
o block
v -0.4 0.6 -0.4
v 0.4 0.6 -0.4
v 0.4 0.6 0.4
v -0.4 0.6 0.4
f 10 9 8 7
END
options=(--size 256x256 --spp 8 --sky 0.6 --seed 3)

mkfifo "$work/display"
Xvfb -displayfd 3 -screen 0 1280x900x24 -nolisten tcp 3> "$work/display" 2> /dev/null &
server=$!
DISPLAY=:$(head -1 "$work/display")
export DISPLAY
"$HALFDOME" view "$work/room.obj" "${options[@]}" --progress none 2> "$work/messages" &
viewer=$!
window=$(xdotool search --sync --onlyvisible --name '^halfdome view$' | head -1)
# A window that is not mapped yet takes no focus.
until xdotool windowfocus --sync "$window" 2> /dev/null; do
    kill -0 "$viewer" 2> /dev/null || fail "the window has closed: $(cat "$work/messages")"
    sleep 0.1
done

shot() {
    for _ in 1 2 3 4 5; do
        timeout 10 import -silent -window "$window" "$shots/$1.png" && return
        echo "view.sh: $1: the screenshot is taken again" >&2
    done
    fail "$1: there is no screenshot"
}
# The picture is left of the text, in the middle: the window is 720 high.
picture() { convert "$shots/$1.png" -crop 256x256+0+232 +repage "$work/picture.png"; }
# Waits until the window shows the picture of a file.
await() {
    for _ in $(seq 600); do
        shot "$1"
        picture "$1"
        [ "$(compare -metric AE "$work/picture.png" "$2" null: 2>&1)" = 0 ] && return
        sleep 0.2
    done
    fail "$1: the window does not show what render makes"
}
differ() {
    [ "$(compare -metric AE "$shots/$1.png" "$shots/$2.png" null: 2>&1)" != 0 ] || fail "$1 and $2 look the same"
}

"$HALFDOME" render "$work/room.obj" "${options[@]}" -o "$work/first.png" --progress none
await first "$work/first.png"

# A click in the middle picks a surface and shows its light paths; the tree and the help have pages of their own.
xdotool mousemove --window "$window" 128 360 click 1
sleep 1
shot picked
differ first picked
for key in o h; do
    xdotool key --window "$window" $key
    sleep 1
    shot "page-$key"
    differ picked "page-$key"
done
xdotool key --window "$window" h

# Exposure is that of PNG files.
xdotool key --window "$window" bracketright bracketright t
"$HALFDOME" render "$work/room.obj" "${options[@]}" --exposure 1 --tone reinhard -o "$work/bright.png" --progress none
xdotool mousemove --window "$window" 500 600
# The frame around the picked pixel goes with a move there and back.
xdotool key --window "$window" Left Right Home
await bright "$work/bright.png"
xdotool key --window "$window" r

# An AOV, and back.
xdotool key --window "$window" a
sleep 2
shot albedo
differ first albedo
xdotool key --window "$window" A

# Orbits, saves, and the saved camera makes the same picture.
xdotool mousemove --window "$window" 100 360 mousedown 1 mousemove --window "$window" 120 370 mousemove --window "$window" 150 380 mouseup 1
xdotool key --window "$window" Up plus s
for _ in $(seq 50); do
    [ -e "$work/room.toml" ] && break
    sleep 0.2
done
[ -e "$work/room.toml" ] || fail "no camera was saved: $(cat "$work/messages")"
"$HALFDOME" render "$work/room.toml" "${options[@]}" -o "$work/moved.png" --progress none
await moved "$work/moved.png"
[ "$(compare -metric AE "$work/first.png" "$work/moved.png" null: 2>&1)" != 0 ] || fail "the camera has not moved"

# The window may be gone before the key is released.
xdotool key --window "$window" q 2> /dev/null || true
code=0
wait "$viewer" || code=$?
viewer=
[ $code -eq 0 ] || fail "the exit code is $code: $(cat "$work/messages")"
grep -q "saved the camera in" "$work/messages" || fail "there is no message about the saved camera: $(cat "$work/messages")"
echo "view.sh: all is well"
