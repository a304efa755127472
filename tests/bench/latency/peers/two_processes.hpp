// Two processes, one sends and the other receives: what comes back from both.
#pragma once

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>

#include "../measured.hpp"

namespace measured {

// In memory that both processes see.
struct Shared {
    std::atomic<bool> all_sent;
    uint64_t received;
    Row rows[1];  // and more behind
};
inline constexpr int kLook_ms = 100;  // how often a receiver looks whether all were sent

inline Shared& make_shared_rows(uint64_t samples) {
    const size_t bytes = sizeof(Shared) + samples * sizeof(Row);
    return *static_cast<Shared*>(
        mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
}

// In the receiver.
inline void note_received(Shared& shared, const void* bytes) {
    Sample sample;
    std::memcpy(&sample, bytes, sizeof sample);
    shared.rows[sample.value[0]].latency_ns = static_cast<uint32_t>(now_ns() - sample.sent_ns);
    ++shared.received;
}

// In the sender, at 1 kHz: `publish` gets each sample.
template <typename Publish>
void send_all(Shared& shared, uint64_t samples, const Publish& publish) {
    uint64_t due_ns = now_ns();
    for (uint64_t i = 0; i < samples; ++i) {
        due_ns += kPeriod_ns;
        sleep_until(due_ns);
        const uint64_t begin_ns = now_ns();
        publish(Sample{.timestamp = 0, .sent_ns = begin_ns, .value = {i, 1, 2, 3, 4, 5}});
        shared.rows[i].call_ns = static_cast<uint32_t>(now_ns() - begin_ns);
    }
    usleep(200'000);  // the last ones arrive
}

// `receive` runs in a process of its own until all were sent. The program's exit status.
template <typename Receive, typename Send>
int measure(uint64_t samples, const Receive& receive, const Send& send) {
    Shared& shared = make_shared_rows(samples);
    const pid_t receiver = fork();
    if (receiver == 0) {
        receive(shared);
        std::exit(0);
    }
    send(shared);
    shared.all_sent = true;
    waitpid(receiver, nullptr, 0);
    for (uint64_t i = 0; i < samples; ++i) print(shared.rows[i]);
    return shared.received == 0 ? 1 : 0;
}

}  // namespace measured
