# docker build -t hhrl-bench .
# docker run --rm hhrl-bench evaluate rule-4
# docker run --rm -v "$PWD:/work" -w /work --user "$(id -u):$(id -g)" -e HOME=/tmp hhrl-bench train ddqn --seeds 0
FROM python:3.11-slim-bookworm
WORKDIR /opt/hhrl-bench
COPY locks/bare.txt locks/
RUN pip install --no-cache-dir --require-hashes --no-deps --requirement locks/bare.txt
COPY . .
RUN pip install --no-cache-dir --no-deps --no-build-isolation . && useradd --create-home bench
USER bench
WORKDIR /home/bench
RUN hhrl-bench evaluate rule-4 --episodes 1
ENTRYPOINT ["hhrl-bench"]
CMD ["--help"]
