// The same from process to process with LCM: `lcm_handover SAMPLES`. Built by `./stator bench
// latency` where liblcm-dev is installed.
#include <lcm/lcm.h>

#include "two_processes.hpp"

namespace {

using measured::Sample;
using measured::Shared;

constexpr char kChannel[] = "SAMPLE";
constexpr char kLocal[] =
    "udpm://239.255.76.67:7667?ttl=0";  // LCM's own address; not beyond this host

void take(const lcm_recv_buf_t* buffer, const char*, void* shared) {
    measured::note_received(*static_cast<Shared*>(shared), buffer->data);
}

void receive(Shared& shared) {
    lcm_t* lcm = lcm_create(kLocal);
    if (lcm == nullptr) return;
    lcm_subscribe(lcm, kChannel, take, &shared);
    while (!shared.all_sent && lcm_handle_timeout(lcm, measured::kLook_ms) >= 0) {
    }
    lcm_destroy(lcm);
}

void send(Shared& shared, uint64_t samples) {
    usleep(500'000);  // the receiver listens by then
    lcm_t* lcm = lcm_create(kLocal);
    if (lcm == nullptr) return;
    measured::send_all(shared, samples, [lcm](const Sample& sample) {
        lcm_publish(lcm, kChannel, &sample, sizeof sample);
    });
    lcm_destroy(lcm);
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 2) return 2;
    const uint64_t samples = std::strtoul(arguments[1], nullptr, 10);
    return measured::measure(samples, receive, [&](Shared& shared) { send(shared, samples); });
}
