"""Print what single faults did: `python -m benchmarks.faults --seeds 1 31`."""

import argparse
from collections import defaultdict

from benchmarks.faults.series import Finding, findings, kind_of


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seeds', nargs=2, type=int, required=True, metavar=('FIRST', 'END'))
    parser.add_argument('--fault', default='', help='only seeds whose fault has this in its name')
    parser.add_argument('--verbose', action='store_true', help='all that is wrong, not the first')
    arguments = parser.parse_args()
    by_fault: dict[str, list[Finding]] = defaultdict(list)
    seeds = [seed for seed in range(*arguments.seeds) if arguments.fault in kind_of(seed)]
    for each in findings(seeds):
        by_fault[each.faults.split(' + ')[0]].append(each)
        _print(each, most=1000 if arguments.verbose else 2)
    print()
    for name, group in sorted(by_fault.items()):
        wrong = sum(bool(each.outside) for each in group)
        clean = sum(each.n_clean_outside for each in group)
        print(
            f'{name:20s} {len(group):4d} runs, {wrong:3d} with values outside and unflagged'
            f' ({sum(len(each.outside) for each in group)} of {sum(e.n_values for e in group)};'
            f' clean {clean} of {sum(e.n_clean_values for e in group)}),'
            f' {sum(each.n_flagged for each in group)} wrong under a flag,'
            f' {sum(bool(each.crash) for each in group)} crashes,'
            f' {sum(each.hangs for each in group)} slow, {sum(e.silent for e in group)} silent,'
            f' results {sum(e.share_identified for e in group) / len(group):.0%}'
        )


def _print(each: Finding, most: int) -> None:
    if not (each.outside or each.crash or each.hangs or each.silent):
        return
    print(
        f'{each.seed} {each.faults}: {each.cpu_s:.1f} s for {each.clean_s:.1f} s, clean'
        f' {each.n_clean_outside}/{each.n_clean_values}, {len(each.outside)}/{each.n_values}'
        f' outside, {each.n_flagged} flagged, {each.share_identified:.0%} of results,'
        f' {each.crash} {each.refusal[:150]} {",".join(each.flags)}',
        flush=True,
    )
    for what in each.outside[:most]:
        print(f'    {what}')


if __name__ == '__main__':
    main()
