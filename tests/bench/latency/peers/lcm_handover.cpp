// The same from process to process with LCM: `lcm_handover SAMPLES`. Built by `./stator bench
// latency` where liblcm-dev is installed.
#include <lcm/lcm.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

#include "../measured.hpp"

namespace {

constexpr char kChannel[] = "SAMPLE";
constexpr char kLocal[] =
    "udpm://239.255.76.67:7667?ttl=0";  // LCM's own address; not beyond this host
constexpr int kLongestPause_ms = 2000;

struct Shared {
    uint64_t received;
    measured::Row rows[1];  // and more behind
};

void take(const lcm_recv_buf_t* buffer, const char*, void* user) {
    auto* shared = static_cast<Shared*>(user);
    measured::Sample sample;
    std::memcpy(&sample, buffer->data, sizeof sample);
    shared->rows[sample.value[0]].latency_ns =
        static_cast<uint32_t>(measured::now_ns() - sample.sent_ns);
    ++shared->received;
}

// Until all have come, or none comes any more.
int receive(Shared& shared, uint64_t count) {
    lcm_t* lcm = lcm_create(kLocal);
    if (lcm == nullptr) return 2;
    lcm_subscribe(lcm, kChannel, take, &shared);
    pollfd wait{lcm_get_fileno(lcm), POLLIN, 0};
    while (shared.received < count && poll(&wait, 1, kLongestPause_ms) > 0) lcm_handle(lcm);
    lcm_destroy(lcm);
    return 0;
}

void send(Shared& shared, uint64_t count) {
    lcm_t* lcm = lcm_create(kLocal);
    uint64_t due_ns = measured::now_ns();
    for (uint64_t i = 0; lcm != nullptr && i < count; ++i) {
        due_ns += measured::kPeriod_ns;
        measured::sleep_until(due_ns);
        const uint64_t begin_ns = measured::now_ns();
        const measured::Sample sample{.sent_ns = begin_ns, .value = {i, 1, 2, 3, 4, 5}};
        lcm_publish(lcm, kChannel, &sample, sizeof sample);
        shared.rows[i].call_ns = static_cast<uint32_t>(measured::now_ns() - begin_ns);
    }
    if (lcm != nullptr) lcm_destroy(lcm);
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 2) return 2;
    const uint64_t samples = std::strtoul(arguments[1], nullptr, 10);
    const size_t bytes = sizeof(Shared) + samples * sizeof(measured::Row);
    auto& shared = *static_cast<Shared*>(
        mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
    const pid_t receiver = fork();
    if (receiver == 0) _exit(receive(shared, samples));
    usleep(500'000);  // the receiver listens by then
    send(shared, samples);
    int status = 0;
    waitpid(receiver, &status, 0);
    for (uint64_t i = 0; i < samples; ++i) measured::print(shared.rows[i]);
    return shared.received == 0 ? 1 : 0;
}
