#include "hammer.hpp"

#include "stator/executor.hpp"

namespace stator::apps::hammer {

namespace {

// Of each source: these outlive a node that is switched off and made anew. One thread each.
std::array<uint64_t, 64> published;

constexpr uint64_t seal_of(uint64_t source, uint64_t value, unsigned place) {
    return (value + place) * 0x9E3779B97F4A7C15U ^ (source << 7);
}

}  // namespace

bool is_whole(const Block& block) {
    for (unsigned i = 0; i < block.seals.size(); ++i) {
        if (block.seals[i] != seal_of(block.source, block.value, i)) return false;
    }
    return block.source < published.size();
}

// `lost`: how many the port says that this input missed just before the sample.
void Hammer::check(Watch& watch, const Input<Block>& input, uint32_t lost) {
    require(is_whole(*input), "stress: a torn sample");
    uint64_t& value = watch.values[input->source];
    require(input.is_new() ? input->value > value : input->value == value,
            "stress: a source goes backwards");
    value = input->value;
    if (watch.has_number && input.is_new()) {
        require(input.number() == watch.number + 1 + lost, "stress: losses are counted wrongly");
    }
    watch.has_number = true;
    watch.number = input.number();
}

void Hammer::linger(int32_t loops) {
    random_ = random_ * 1664525U + 1013904223U;
    const auto most = static_cast<int32_t>(random_ >> 8) % (loops + 1);
    for (int32_t i = 0; i < most; ++i) asm volatile("" ::: "memory");
}

void Hammer::publish(HammerPorts& ports) {
    const auto source = static_cast<uint64_t>(ports.params->id);
    for (Output<Block>* output : {&ports.out, &ports.more}) {
        if (!output->is_connected()) continue;
        for (int32_t i = 0; i < ports.params->count; ++i) {
            const uint64_t value = ++published[source];
            output->publish([&] {
                Block block{.source = source, .value = value};
                for (unsigned k = 0; k < block.seals.size(); ++k) {
                    block.seals[k] = seal_of(source, value, k);
                }
                return block;
            });
        }
    }
}

void Hammer::step(HammerPorts& ports) {
    if (ports.a) check(a_, ports.a, ports.a.lost());
    if (ports.c) check(c_, ports.c, ports.c.lost());
    uint32_t lost = 0;
    while (ports.b.next()) {
        check(b_, ports.b, ports.b.lost() - lost);
        lost = ports.b.lost();
        linger(ports.params->linger);
        require(is_whole(*ports.b), "stress: a queued sample was reused");
    }
    linger(ports.params->linger);
    publish(ports);
    if (ports.a) require(is_whole(*ports.a), "stress: a trigger sample was reused");
    if (ports.c) require(is_whole(*ports.c), "stress: a newest sample was reused");
}

}  // namespace stator::apps::hammer
