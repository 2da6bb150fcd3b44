# Sourced by the tests that need Node.js and a headless Chromium. On Debian and Ubuntu it installs what is missing (as root,
# or by sudo).
packages=()
command -v node > /dev/null || packages+=(nodejs npm)
[ -n "${CHROMIUM:-}" ] || command -v chromium > /dev/null || packages+=(chromium)
if [ ${#packages[@]} -gt 0 ]; then
    sudo=$([ "$(id -u)" -eq 0 ] || echo sudo)
    $sudo apt-get update
    $sudo apt-get install -y --no-install-recommends "${packages[@]}"
fi
