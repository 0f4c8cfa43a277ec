# robot-assistant of this checkout, told of in docs/ci.md:
#   docker build --tag robot-assistant .
#   docker run --rm --volume "$PWD:/work" robot-assistant check
FROM python:3.12-slim

COPY . /opt/checkout
RUN python -m pip install --no-cache-dir "/opt/checkout[virtual,rws]"

WORKDIR /work
ENTRYPOINT ["robot-assistant"]
CMD ["check"]
