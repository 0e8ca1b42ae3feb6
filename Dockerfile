# The programs of piste on Debian 13.
#   docker build --tag piste . && docker run --rm --volume "$PWD:/work" piste piste-replay run.yaml
FROM debian:13-slim AS build
WORKDIR /source
COPY . .
RUN scripts/package

FROM debian:13-slim
COPY --from=build /source/build/package/piste_*.deb /opt/
# hadolint ignore=DL3008
RUN apt-get update && apt-get install --yes --no-install-recommends /opt/piste_*.deb && rm -rf /opt/piste_*.deb /var/lib/apt/lists/*
WORKDIR /work
CMD ["piste-replay", "--help"]
