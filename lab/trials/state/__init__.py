"""What a node promises of its state and its bags, shown: `python -m
lab.trials.state`.
"""
