// The same from process to process with ROS 1: `ros_handover SAMPLES`, with a master. Built by
// `./stator bench latency` where libroscpp-dev is installed.
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_msgs/String.h>

#include "two_processes.hpp"

namespace {

using measured::Sample;
using measured::Shared;

constexpr char kTopic[] = "sample";

void init(const char* name) {
    ros::init(ros::M_string(), name, ros::init_options::NoSigintHandler);
}

void receive(Shared& shared) {
    init("sink");
    ros::NodeHandle node;
    const auto take = [&shared](const std_msgs::String::ConstPtr& message) {
        measured::note_received(shared, message->data.data());
    };
    const ros::Subscriber subscriber = node.subscribe<std_msgs::String>(
        kTopic, 10, take, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
    while (!shared.all_sent) {
        ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(1e-3 * measured::kLook_ms));
    }
}

void send(Shared& shared, uint64_t samples) {
    init("source");
    ros::NodeHandle node;
    const ros::Publisher publisher = node.advertise<std_msgs::String>(kTopic, 10);
    while (publisher.getNumSubscribers() == 0) usleep(10'000);
    measured::send_all(shared, samples, [&publisher](const Sample& sample) {
        std_msgs::String message;
        message.data.assign(reinterpret_cast<const char*>(&sample), sizeof sample);
        publisher.publish(message);
    });
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 2) return 2;
    const uint64_t samples = std::strtoul(arguments[1], nullptr, 10);
    return measured::measure(samples, receive, [&](Shared& shared) { send(shared, samples); });
}
