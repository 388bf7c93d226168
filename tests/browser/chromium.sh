#!/bin/sh
# The browser suite drives the system's Chromium. Install it where we may, else say what to install.
set -eu
for name in "${CHROMIUM:-}" chromium chromium-browser google-chrome; do
  [ -n "$name" ] && command -v "$name" >/dev/null 2>&1 && exit 0
done
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
  echo "installing chromium for the browser tests"
  apt-get update -qq
  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium fonts-dejavu-core >/dev/null
elif [ "$(id -u)" = 0 ] && command -v dnf >/dev/null 2>&1; then
  dnf install -y -q chromium dejavu-sans-fonts
elif [ "$(id -u)" = 0 ] && command -v apk >/dev/null 2>&1; then
  apk add --quiet chromium font-dejavu
else
  echo "The browser tests need Chromium. Install it (Debian: sudo apt-get install chromium) or name one: CHROMIUM=/path/to/chrome make test" >&2
  exit 1
fi
