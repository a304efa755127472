// Topologies by enumeration, and the slot formula of the compiler (codegen/stator/plan/topics.py)
// once more; a test compares the two.
#include "topology.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <sstream>

namespace stator::explorer {

namespace {

constexpr std::array kRoles = {'r', 'q', 'w', 'b', 'B'};

bool has_one_to_three_publishers(const Topology& topology) {
    const auto count = std::ranges::count_if(
        topology.users, [](const TopicUser& user) { return user.role.publishes(); });
    return count >= 1 && count <= 3;
}

}  // namespace

std::string Topology::name() const {
    std::ostringstream text;
    for (const TopicUser& user : users) text << user.level << user.role.letter << ' ';
    text << "depth " << depth;
    return text.str();
}

unsigned Topology::top() const {
    unsigned top = 0;
    for (const TopicUser& user : users) {
        if (user.role.publishes()) top = std::max(top, user.level);
    }
    return top;
}

unsigned Topology::ceiling() const {
    const unsigned highest = top();
    const bool several = std::ranges::any_of(users, [=](const TopicUser& user) {
        return user.role.publishes() && user.level != highest;
    });
    return several ? highest : 0;
}

bool Topology::takes_turns() const {
    return depth == 1 && std::ranges::all_of(users, [this](const TopicUser& user) {
               if (user.role.publishes()) return user.level == top() && !user.role.reads();
               return user.level >= top();
           });
}

bool Topology::is_read_above(unsigned level) const {
    return std::ranges::any_of(
        users, [=](const TopicUser& user) { return user.role.reads() && user.level > level; });
}

unsigned Topology::slots() const {
    const unsigned highest = top();
    unsigned kept = is_read_above(highest) ? 1 : 0;
    std::map<unsigned, unsigned> held;
    for (const auto& [level, role] : users) {
        const unsigned holds = role.reads() && role.publishes() ? 2 : 1;
        if (level < highest) held[level] = std::max(held[level], holds);
        if (level == highest && holds == 2) kept = 1;
    }
    unsigned sum = (depth - 1) + kept + 1;
    for (const auto& [level, holds] : held) sum += holds;
    return sum;
}

bool Topology::has_slot_to_spare() const {
    const unsigned highest = top();
    if (depth == 1 || is_read_above(highest)) return false;
    bool reads_newest = false;
    bool reads_queue = false;
    for (const auto& [level, role] : users) {
        if (level != highest || !role.publishes()) continue;
        reads_newest = reads_newest || role.letter == 'b';
        reads_queue = reads_queue || role.letter == 'B';
    }
    return reads_newest && !reads_queue;
}

Topology parse_topology(const std::string& text, unsigned depth) {
    Topology topology{{}, depth};
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        topology.users.push_back({static_cast<unsigned>(word[0] - '0'), {word[1]}});
    }
    return topology;
}

std::vector<Topology> all_topologies(unsigned levels, unsigned depth) {
    std::vector<Topology> all = {Topology{{}, depth}};
    for (unsigned level = 1; level <= levels; ++level) {
        std::vector<Topology> longer;
        for (const Topology& topology : all) {
            for (const char role : kRoles) {
                longer.push_back(topology);
                longer.back().users.push_back({level, {role}});
            }
        }
        all = longer;
    }
    std::erase_if(all, [](const Topology& t) { return !has_one_to_three_publishers(t); });
    return all;
}

std::vector<Topology> shared_level_topologies(unsigned levels, unsigned depth) {
    std::vector<Topology> all;
    for (unsigned shared = 1; shared <= levels; ++shared) {
        for (const char first : kRoles) {
            for (const char second : kRoles) {
                if (first >= second) continue;
                if (levels == 1) {
                    all.push_back({{{1, {first}}, {1, {second}}}, depth});
                    continue;
                }
                for (const char other : kRoles) {
                    Topology topology{{{shared, {first}}, {shared, {second}}}, depth};
                    const bool below = shared == 2;
                    topology.users.insert(below ? topology.users.begin() : topology.users.end(),
                                          {3 - shared, {other}});
                    all.push_back(topology);
                }
            }
        }
    }
    std::erase_if(all, [](const Topology& t) { return !has_one_to_three_publishers(t); });
    return all;
}

}  // namespace stator::explorer
