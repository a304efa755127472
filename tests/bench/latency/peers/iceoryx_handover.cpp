// The same from process to process with iceoryx: `iceoryx_handover SAMPLES`, with its daemon
// iox-roudi. Built by `./stator bench latency` where libiceoryx-posh-dev is installed.

#include "iceoryx_posh/popo/publisher.hpp"
#include "iceoryx_posh/popo/subscriber.hpp"
#include "iceoryx_posh/popo/wait_set.hpp"
#include "iceoryx_posh/runtime/posh_runtime.hpp"
#include "two_processes.hpp"

namespace {

using measured::Sample;
using measured::Shared;

const iox::capro::ServiceDescription kTopic{"Stator", "Latency", "Sample"};

void receive(Shared& shared) {
    iox::runtime::PoshRuntime::initRuntime("sink");
    iox::popo::Subscriber<Sample> subscriber(kTopic);
    iox::popo::WaitSet<> waiting;
    const auto attached = waiting.attachState(subscriber, iox::popo::SubscriberState::HAS_DATA);
    const auto look = iox::units::Duration::fromMilliseconds(measured::kLook_ms);
    while (!attached.has_error() && !shared.all_sent) {
        waiting.timedWait(look);
        while (subscriber.hasData()) {
            subscriber.take().and_then(
                [&](const auto& sample) { measured::note_received(shared, sample.get()); });
        }
    }
}

void send(Shared& shared, uint64_t samples) {
    iox::runtime::PoshRuntime::initRuntime("source");
    iox::popo::Publisher<Sample> publisher(kTopic);
    while (!publisher.hasSubscribers()) usleep(10'000);
    measured::send_all(shared, samples, [&publisher](const Sample& sample) {
        publisher.loan().and_then([&](auto& loan) {
            *loan = sample;
            loan.publish();
        });
    });
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 2) return 2;
    const uint64_t samples = std::strtoul(arguments[1], nullptr, 10);
    return measured::measure(samples, receive, [&](Shared& shared) { send(shared, samples); });
}
