"""The answering thread: one reply for each packet, none for those that piled up."""

import time

import numpy as np
import pytest

from robot_bridge.egm.egm_link import bound_socket, EgmLink, receipt_ns
from robot_bridge.egm.session_check import SessionCheck, SessionLimits
from robot_bridge.player.plan_player import Reference

N_WAITING, STALE_S = 60, 0.02


@pytest.fixture
def link():
    """Return a link that is bound and does not run yet, and what it heard."""
    heard = []

    def answer(feedback, judgement, now_s, receipt_ns):
        heard.append((feedback.seqno, judgement.n_steps))
        return Reference(np.array(feedback.planned_deg), np.zeros(6))

    made = EgmLink(
        '127.0.0.1',
        0,
        SessionCheck(SessionLimits(controller_address='127.0.0.1')),
        answer,
        lambda reason: heard.append(reason),
        lambda now_s: None,
        stale_s=STALE_S,
    )
    yield made, heard
    made.close()


def wait_for_arrival_stamps():
    """Wait until the kernel stamps what arrives: a moment after the first socket asks for it.

    Before, a packet is stamped when it is read, and cannot be seen to have waited.
    """
    probe = bound_socket('127.0.0.1', 0)
    with probe:
        while True:
            probe.sendto(b'?', probe.getsockname())
            time.sleep(STALE_S)
            _, ancillary, _, _ = probe.recvmsg(16, 64)
            if time.time_ns() - receipt_ns(ancillary) > 0.5e9 * STALE_S:
                return


def replies(peers, peer, n, patience_s=30.0):
    """Return the next n replies."""
    peer.socket.settimeout(patience_s)
    return [peers.EgmSensor.FromString(peer.socket.recv(4096)) for _ in range(n)]


def test_packets_that_piled_up_leave_no_queue_of_answers(peers, link):
    made, heard = link
    wait_for_arrival_stamps()
    peer = peers.StrictPeer([0.0] * 6, made.address)
    # The process stands still while the controller goes on.
    for _ in range(N_WAITING):
        peer.socket.sendto(peer.packet(), made.address)
        peer.seqno += 1
    time.sleep(2 * STALE_S)
    made.start()
    # Only the newest is worth an answer: a controller reads one in each cycle.
    (first,) = replies(peers, peer, 1)
    assert (first.header.seqno, heard) == (0, [(N_WAITING - 1, 1)])
    assert made.check.counts['stale'] == N_WAITING - 1
    for number in range(1, 6):
        peer.socket.sendto(peer.packet(), made.address)
        peer.seqno += 1
        (reply,) = replies(peers, peer, 1)
        assert reply.header.seqno == number
    peer.socket.settimeout(0.05)
    with pytest.raises(TimeoutError):
        peer.socket.recv(4096)
    peer.close()


def test_a_gap_of_stale_packets_counts_as_missed_cycles(peers, link):
    made, heard = link
    peer = peers.StrictPeer([0.0] * 6, made.address)
    made.start()
    peer.socket.sendto(peer.packet(), made.address)
    replies(peers, peer, 1)
    # Heard as after a loss of nine packets: the flow decides what that means.
    peer.seqno = 10
    peer.socket.sendto(peer.packet(), made.address)
    replies(peers, peer, 1)
    assert heard == [(0, 1), (10, 10)]
    assert made.check.counts['missed_cycles'] == 9
    peer.close()


def test_a_refused_packet_is_told_by_its_field(peers, link):
    made, heard = link
    peer = peers.StrictPeer([0.0] * 6, made.address)
    made.start()
    packet = peers.EgmRobot.FromString(peer.packet())
    packet.planned.ClearField('time')
    peer.socket.sendto(packet.SerializeToString(), made.address)
    deadline = time.monotonic() + 30.0
    while not made.refusal and time.monotonic() < deadline:
        time.sleep(0.002)
    assert made.check.counts['malformed'] == 1 and heard == []
    assert made.refusal == made.last_refusal == 'EgmRobot.planned.time: field missing'
    peer.seqno += 1
    peer.socket.sendto(peer.packet(), made.address)
    replies(peers, peer, 1)
    # What was refused before is no reason for a silence of now.
    assert made.refusal == '' and made.last_refusal
    peer.close()
