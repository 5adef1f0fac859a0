#!/bin/sh
# install.sh VENV WHEEL: the package with what the study needs, in a virtual environment. Libraries as constraints.txt pins them.
set -eu
here=$(cd "$(dirname "$0")/.." && pwd)
python3 -m venv "$1"
"$1/bin/pip" install --no-cache-dir --quiet --constraint "$here/constraints.txt" "gtm-fmu[study,train,cross] @ file://$2"
"$1/bin/gtm-fmu" doctor
