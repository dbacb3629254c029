"""What the tests of faults see and do: the wrist as the robot reports it, and scans that must end."""

import threading
import time

from graph import Listener
from processes import wait_until

W2 = 'left_w2'
STILL_RAD = 2e-3


class Wrist:
    """Where the wrist of the simulated robot is, as the main computer hears it."""

    def __init__(self):
        import rospy
        from sensor_msgs.msg import JointState
        self.angle_rad = None
        self.heard = 0
        self.subscriber = rospy.Subscriber('/robot/joint_states', JointState, self._note)
        wait_until(lambda: self.angle_rad is not None, 10, 'joint states')

    def _note(self, message):
        self.heard += 1
        if W2 in message.name:
            self.angle_rad = message.position[message.name.index(W2)]

    def moves(self, timeout_s=15):
        """Waits until it turns."""
        begin = self.angle_rad
        wait_until(lambda: abs(self.angle_rad - begin) > 0.1, timeout_s, 'motion', period_s=0.005)

    def rests(self, timeout_s):
        """Waits until it is still; returns where."""
        def still():
            before = self.angle_rad
            time.sleep(0.2)
            return abs(self.angle_rad - before) < STILL_RAD
        wait_until(still, timeout_s, 'rest', period_s=0)
        return self.angle_rad


class Scan:
    """A scan in the background, by steps: a sweep may have its answer before the wrist turns."""

    def __init__(self, graph, views=3):
        self.begun = time.monotonic()
        self.response, self.failure, self.took_s = None, None, None
        self.thread = threading.Thread(target=self._work, args=(graph, views), daemon=True)
        self.thread.start()

    def _work(self, graph, views):
        try:
            self.response = graph.scan(views, timeout_s=60)
        except Exception as error:  # what a caller sees whose connection is cut
            self.failure = error
        self.took_s = time.monotonic() - self.begun

    def result(self, timeout_s):
        """The response; fails when it takes longer than that from now on."""
        self.thread.join(timeout_s)
        assert self.took_s is not None, f'no answer within {timeout_s} s'
        if self.failure:
            raise self.failure
        return self.response


class Answers:
    """All that the classifier says: none of it may be wrong and called known."""

    def __init__(self, truth):
        from deformable_cobot.msg import Classification
        self.truth = truth
        self.listener = Listener('classification', Classification)

    def check(self):
        wrong = [answer for answer in self.listener.all() if answer.known and answer.label != self.truth]
        assert not wrong, wrong


def recovers(graph, timeout_s=30, label='medium-can'):
    """Waits for a scan that succeeds, without anybody's help."""
    errors = []

    def succeeds():
        try:
            response = graph.scan(timeout_s=30)
        except Exception as error:
            errors.append(str(error))
            return False
        errors.append(response.error)
        return response.error == '' and response.result.label == label and response.result.known
    begin = time.monotonic()
    try:
        wait_until(succeeds, timeout_s, 'a scan after the fault', period_s=0.5)
    except TimeoutError as error:
        raise AssertionError(f'{error}: {errors}') from None
    print(f'recovered after {time.monotonic() - begin:.1f} s; errors on the way: {errors[:-1]}')
