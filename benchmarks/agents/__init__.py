"""Agents on chat models, measured: adversarial replies, and real small models from files."""
