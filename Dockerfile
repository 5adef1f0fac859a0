# The study in a container; the results come to build/study, as files of who runs it:
#   docker build --tag gtm-fmu .
#   mkdir -p build/study && docker run --rm --user "$(id -u)" --volume "$PWD/build/study:/results/study" gtm-fmu
# Any other command: docker run --rm gtm-fmu envelope --altitude-ft 10000
# torch comes with its libraries for graphics cards, gigabytes, unless another index is given as PIP_EXTRA_INDEX_URL.
FROM python:3.11-slim-bookworm AS build
ARG PIP_EXTRA_INDEX_URL=
SHELL ["/bin/bash", "-euo", "pipefail", "-c"]
# hadolint ignore=DL3008
RUN apt-get update && apt-get install --yes --no-install-recommends gcc libc6-dev && rm -rf /var/lib/apt/lists/*
WORKDIR /source
COPY . .
RUN pip wheel --no-cache-dir --quiet --no-deps --wheel-dir /wheels . && container/install.sh /opt/gtm-fmu /wheels/*.whl

FROM python:3.11-slim-bookworm
COPY --from=build /opt/gtm-fmu /opt/gtm-fmu
RUN useradd --create-home --uid 1000 pilot && mkdir --parents /results/study && chown --recursive 1000 /results
USER 1000
WORKDIR /results
ENV PATH=/opt/gtm-fmu/bin:$PATH HOME=/tmp CC="python3 -m ziglang cc"
ENTRYPOINT ["gtm-fmu"]
CMD ["study", "--output", "study"]
