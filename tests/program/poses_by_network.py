"""What tests of trackers over the network have in common."""
import csv
import signal

from program import ProgramTest


class PosesByNetworkTest(ProgramTest):
    def rows(self, name):
        with open(self.path(name), encoding="ascii") as file:
            return list(csv.DictReader(file))

    def ends_at_ctrl_c(self, running):
        running.send(signal.SIGINT)
        done = running.ends()
        self.assertEqual(done.code, 0, done)
        return done
