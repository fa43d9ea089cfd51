"""The fit of the split estimator to drops of many families of bodies, and its
judgement.
"""
